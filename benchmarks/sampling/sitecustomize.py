"""Samples what a node spends its CPU time on; Python imports this module from PYTHONPATH.

With TAUTO_SAMPLES, a folder, a process that spins notes every 5 ms of its own CPU time whether our
Python code or rclpy (with the middleware below it) is running. It counts the messages that it
publishes, a pack as one, and writes all counts at its end.
"""

import atexit
import json
import os
import signal
import sys
from collections import Counter
from pathlib import Path
from types import FrameType

PERIOD_S = 0.005
ENTRIES = {'_spin', 'guarded', 'check'}
"""What rclpy calls first. Python handles a signal that came in C only here, and what these
functions do themselves is nothing: the time before was rclpy's, or that of a thread of DDS."""

_counts: Counter[str] = Counter()


def _note(number: int, frame: FrameType | None) -> None:
    del number
    spinning, at = False, frame
    while at is not None and not spinning:
        spinning = at.f_code.co_name == '_spin'
        at = at.f_back
    if not spinning or frame is None:
        return
    file = frame.f_code.co_filename
    ours = '/rclpy/' not in file and frame.f_code.co_name not in ENTRIES
    _counts['ours' if ours else 'rclpy'] += 1


class _CountsPublished:
    """Finds nothing; wraps `publish` as soon as rclpy's publisher has been imported."""

    def find_spec(self, *_: object) -> None:
        publisher = getattr(sys.modules.get('rclpy.publisher'), 'Publisher', None)
        if publisher is None:
            return
        sys.meta_path.remove(self)
        publish = publisher.publish

        def counted(self: object, message: object) -> None:
            _counts['published'] += 1
            publish(self, message)

        publisher.publish = counted


def _write(folder: str) -> None:
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    (Path(folder) / f'{os.getpid()}.json').write_text(json.dumps(_counts), 'utf-8')


if 'TAUTO_SAMPLES' in os.environ:
    signal.signal(signal.SIGPROF, _note)
    signal.setitimer(signal.ITIMER_PROF, PERIOD_S, PERIOD_S)
    sys.meta_path.insert(0, _CountsPublished())  # type: ignore[arg-type]
    atexit.register(_write, os.environ['TAUTO_SAMPLES'])

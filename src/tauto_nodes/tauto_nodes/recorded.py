"""What the recorder says of a voyage, while it runs and at its end, in the file named `report`."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Recorded:
    """The report of the recorder.

    Times are those of `time.monotonic()`, which on Linux is one clock for all processes.

    Args:
        complete: whether the ends of all topics had come.
        began_s: when its first message came [s]; None: none came.
        closed_s: when the bag was closed [s]; None: it is open.
        topics: received, written and lost, by topic.
        heard_s: when each node of the graph was last heard [s].
        moved_s: when the report of any of them last said something new [s].
    """

    complete: bool
    began_s: float | None
    closed_s: float | None
    topics: dict[str, Any]
    heard_s: dict[str, float]
    moved_s: float

    def write(self, file: Path) -> None:
        """Write the report, as JSON."""
        file.write_text(json.dumps(asdict(self)), 'utf-8')

    @staticmethod
    def read(file: Path) -> Recorded | None:
        """Return the report; None if there is none yet.

        Raises:
            ValueError: it is being written, or there was no room for it.
        """
        try:
            return Recorded(**json.loads(file.read_text('utf-8')))
        except FileNotFoundError:
            return None

"""Mutated bags and scenes: the readers refuse them or read them, and neither crash, hang nor grow.

    .venv/bin/python benchmarks/fuzz.py [--count 1000000] [--what mcap scene] [--seed 1727]

Every input is a valid one with a few changes: bits, bytes and numbers, pieces removed, repeated
or exchanged, of scenes also values and keys. Input k of a seed is always the same. What
ends other than by an error of the package, takes longer than 10 s or makes the process larger by
more than 64 MiB after the first thousand is printed with its number; its input is kept in --keep,
and the exit code is 1.
"""

from __future__ import annotations

import argparse
import json
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

from tauto_core.bags import read_bag
from tauto_core.scene import load_scene, parse_scene
from tauto_core.scene.errors import TautoError
from tauto_core.scene.loader import _SHIPPED
from tauto_core.voyage import sail

LIMIT_S = 10
GROWTH_KIB = 64 * 1024
WARM = 1000
MOST_CHANGES = 6
NUMBERS = (0, 1, 0x7F, 0x80, 0xFF, 2**15, 2**31 - 1, 2**31, 2**32 - 1, 2**63, 2**64 - 1)
VALUES = [
    *('0', '-1', '1e308', '-1e-308', '1e400', '.nan', '.inf', '0x10', '1_000', 'null', 'true'),
    *('[]', '{}', '""', '[1, 2]', '{a: 1}', '2026-01-01', '1727-02-29T00:00:00Z', 'measured'),
    *('&a', '*a', '!!python/object:os.system x', '[' * 2000, '{a: ' * 500, 'x' * 5000),
]


class HangError(Exception):
    """A reader has taken longer than LIMIT_S."""


def mutated(rng: random.Random, seeds: Sequence[bytes]) -> bytes:
    """Return one of the seeds with a few changes to its bytes."""
    data = bytearray(rng.choice(seeds))
    for _ in range(rng.randint(1, MOST_CHANGES)):
        at = rng.randrange(len(data) or 1)
        length = min(rng.choice((1, 2, 4, 8, 64, 1024)), len(data) - at)
        match rng.randrange(7):
            case 0 if data:
                data[at] ^= 1 << rng.randrange(8)
            case 1:
                data[at : at + length] = rng.randbytes(length)
            case 2:
                del data[at : at + length]
            case 3:
                data[at:at] = data[at : at + length]
            case 4:
                width = rng.choice((1, 2, 4, 8))
                number = rng.choice(NUMBERS) % 256**width
                data[at : at + width] = number.to_bytes(width, 'little')
            case 5:
                other = rng.choice(seeds)
                where = rng.randrange(len(other))
                data[at : at + length] = other[where : where + length]
            case _:
                del data[at:]
    return bytes(data)


def mutated_scene(rng: random.Random, seeds: Sequence[bytes]) -> bytes:
    """Return one of the seeds with changes to its lines, or to its bytes."""
    if rng.randrange(3) == 0:
        return mutated(rng, seeds)
    lines = rng.choice(seeds).decode().splitlines()
    for _ in range(rng.randint(1, MOST_CHANGES)):
        if not lines:
            break
        at = rng.randrange(len(lines))
        key, colon, _ = lines[at].partition(':')
        match rng.randrange(5):
            case 0:
                lines[at] = f'{key}{colon} {rng.choice(VALUES)}'
            case 1:
                del lines[at]
            case 2:
                lines.insert(rng.randrange(len(lines)), lines[at])
            case 3:
                lines[at] = ' ' * rng.randrange(6) + lines[at].strip()
            case _:
                other = rng.choice(seeds).decode().splitlines()
                lines.insert(at, rng.choice(other))
    return '\n'.join(lines).encode()


def read_mcap(data: bytes, folder: Path) -> None:
    """Read all of a file as `tauto replay` does."""
    file = folder / 'mutated.mcap'
    file.write_bytes(data)
    bag = read_bag(file)
    for topic in bag.topics:
        bag.payloads(topic)
        bag.samples(topic)
    _ = bag.scene


def read_scene(data: bytes, folder: Path) -> None:
    """Read a scene as the recorder does, and as a file."""
    file = folder / 'mutated.yaml'
    file.write_bytes(data)
    load_scene(file)
    parse_scene(data.decode('utf-8', 'replace'), 'fuzz')


def mcap_seeds(folder: Path) -> list[bytes]:
    """Return small bags of several scenes, most of them with few messages."""
    seeds = []
    for scene, duration in (('ideal', 600.0), ('measured', 2.0), ('globe_in_oil', 3.0)):
        out = folder / scene
        sail(load_scene(scene, duration=duration), out)
        seeds.append(next(out.glob('*.mcap')).read_bytes())
    return seeds


@dataclass
class Findings:
    """What came of the inputs: how often each end, and the faults."""

    ends: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)


def fuzz(
    name: str,
    read: Callable[[bytes], None],
    inputs: Callable[[int], bytes],
    count: int,
    keep: Path,
) -> Findings:
    """Read this many inputs."""
    found = Findings()
    warm_kib = 0
    for number in range(count):
        data = inputs(number)
        signal.alarm(LIMIT_S)
        try:
            read(data)
            found.ends['read'] += 1
        except TautoError:
            found.ends['refused'] += 1
        except Exception as error:
            end = f'{type(error).__name__} at {traceback.extract_tb(error.__traceback__)[-1][:2]}'
            found.ends[end] += 1
            if found.ends[end] == 1:
                keep.mkdir(parents=True, exist_ok=True)
                (keep / f'{name}_{number}').write_bytes(data)
                found.faults.append(f'{name} {number}: {end}: {str(error)[:200]}')
        finally:
            signal.alarm(0)
        if number == WARM:
            warm_kib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    grown_kib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - warm_kib
    if warm_kib and grown_kib > GROWTH_KIB:
        found.faults.append(f'{name}: the process grew by {grown_kib / 1024:.0f} MiB')
    return found


def _hang(number: int, frame: FrameType | None) -> None:
    del number, frame
    raise HangError(f'more than {LIMIT_S} s')


def main() -> int:
    """Mutate and read; print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--count', type=int, default=1_000_000, help='inputs of each kind')
    parser.add_argument('--what', nargs='+', choices=('mcap', 'scene'), default=['mcap', 'scene'])
    parser.add_argument('--seed', type=int, default=1727)
    kept = Path(tempfile.gettempdir()) / 'tauto_fuzz'
    parser.add_argument('--keep', type=Path, default=kept)
    asked = parser.parse_args()
    signal.signal(signal.SIGALRM, _hang)
    faults: list[str] = []
    with tempfile.TemporaryDirectory(prefix='tauto_fuzz_') as temporary:
        folder = Path(temporary)
        for what in asked.what:
            if what == 'mcap':
                seeds, change, read = mcap_seeds(folder), mutated, read_mcap
            else:
                seeds = [file.read_bytes() for file in sorted(_SHIPPED.glob('*.yaml'))]
                change, read = mutated_scene, read_scene

            def made(number: int, seeds=seeds, change=change) -> bytes:  # type: ignore[no-untyped-def]
                return change(random.Random(f'{asked.seed} {number}'), seeds)

            began_s = time.monotonic()
            found = fuzz(
                what, lambda data, read=read: read(data, folder), made, asked.count, asked.keep
            )
            faults += found.faults
            seconds = round(time.monotonic() - began_s, 1)
            print(json.dumps({'what': what, 'seconds': seconds, **dict(found.ends)}))
    print('\n'.join(faults))
    return 1 if faults else 0


if __name__ == '__main__':
    sys.exit(main())

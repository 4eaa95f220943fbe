"""Mutated bags, indices, metadata and scenes: they are refused or read, without a crash or hang.

    .venv/bin/python benchmarks/fuzz.py [--count 1000000] [--first 0] [--what mcap index …]

Every input is a valid one with a few changes: bits, bytes and numbers, pieces removed, repeated
or exchanged, for scenes also values and keys. Input k of a --seed is always the same. An input
that ends other than by an error of the package, takes more than 10 s of CPU time or makes the
process larger by more than 64 MiB after the first thousand is printed with its number and kept in
--keep, and the exit code is 1. Results so far, of each kind: benchmarks/fuzz.json.
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
from functools import partial
from pathlib import Path
from types import FrameType

from tauto_core.bags import check_bag, read_bag
from tauto_core.scene import load_scene, parse_scene
from tauto_core.scene.errors import TautoError
from tauto_core.scene.loader import _SHIPPED
from tauto_core.voyage import sail

LIMIT_S = 10.0
GROWTH_MIB = 64
WARM = 1000
SCENES = {'ideal': 600.0, 'measured': 2.0, 'globe_in_oil': 3.0}  # [s]
TELL = 5_000
RESULTS = Path(__file__).with_suffix('.json')
MOST_CHANGES = 6
NUMBERS = (0, 1, 0x7F, 0x80, 0xFF, 2**15, 2**31 - 1, 2**31, 2**32 - 1, 2**63, 2**64 - 1)
VALUES = [
    *('0', '-1', '1e308', '-1e-308', '1e400', '.nan', '.inf', '0x10', '1_000', 'null', 'true'),
    *('[]', '{}', '""', '[1, 2]', '{a: 1}', '2026-01-01', '1727-02-29T00:00:00Z', 'measured'),
    *('&a', '*a', '!!python/object:os.system x', '[' * 2000, '{a: ' * 500, 'x' * 5000),
]


Change = Callable[[random.Random, Sequence[bytes]], bytes]


class HangError(Exception):
    """A reader has taken more than LIMIT_S of CPU time."""


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


def mutated_index(rng: random.Random, seeds: Sequence[bytes]) -> bytes:
    """Return one of the seeds with changes to its index alone, which has no checksum then."""
    seed = rng.choice(seeds)
    at = int.from_bytes(seed[-28:-20], 'little')
    data = bytearray(seed[at:-37])
    for _ in range(rng.randint(1, MOST_CHANGES)):
        place, width = rng.randrange(len(data) - 8), rng.choice((1, 2, 4, 8))
        number = rng.choice((rng.choice(NUMBERS), rng.randrange(2 * len(seed))))
        data[place : place + width] = (number % 256**width).to_bytes(width, 'little')
    return seed[:at] + bytes(data) + seed[-37:-12] + bytes(4) + seed[-8:]


def changed(change: Change, seeds: Sequence[bytes], seed: int, number: int) -> bytes:
    """Return an input, which depends on seed and number alone."""
    return change(random.Random(f'{seed} {number}'), seeds)


def read_mcap(folder: Path, data: bytes) -> None:
    """Read all of a file as `tauto replay` does, and, if its length is odd, check it."""
    file = folder / 'mutated.mcap'
    file.write_bytes(data)
    bag = read_bag(file)
    for topic in bag.topics:
        bag.payloads(topic)
        bag.samples(topic)
    if bag.scene is None or len(data) % 2:
        check_bag(file)


def read_metadata(folder: Path, data: bytes) -> None:
    """Check and open the bag of an ideal clock with these metadata."""
    (folder / 'ideal' / 'metadata.yaml').write_bytes(data)
    check_bag(folder / 'ideal')
    read_bag(folder / 'ideal')


def read_scene(folder: Path, data: bytes) -> None:
    """Read a scene as a file, or, if its length is odd, as the recorder does."""
    if len(data) % 2:
        parse_scene(data.decode('utf-8', 'replace'), 'fuzz')
        return
    file = folder / 'mutated.yaml'
    file.write_bytes(data)
    load_scene(file)


KINDS = {
    'mcap': (mutated, read_mcap, '*/*.mcap'),
    'index': (mutated_index, read_mcap, '*/*.mcap'),
    'metadata': (mutated_scene, read_metadata, 'ideal/metadata.yaml'),
    'scene': (mutated_scene, read_scene, '*.yaml'),
}


@dataclass
class Findings:
    """The outcome of the inputs: their number, how often each end occurred, growth, faults."""

    first: int = 0
    inputs: int = 0
    seconds: float = 0.0
    grown_mib: float = 0.0
    ends: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)


def fuzz(
    name: str,
    read: Callable[[bytes], None],
    inputs: Callable[[int], bytes],
    numbers: range,
    keep: Path,
) -> Findings:
    """Read this many inputs; report progress after every TELL of them."""
    found, began_s = Findings(numbers.start), time.monotonic()
    warm_kib = 0
    for number in numbers:
        data = inputs(number)
        signal.setitimer(signal.ITIMER_PROF, LIMIT_S)  # CPU time: a busy machine is no hang
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
            signal.setitimer(signal.ITIMER_PROF, 0.0)
        found.inputs += 1
        if found.inputs == WARM:
            warm_kib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        if found.inputs % TELL == 0 or found.inputs == len(numbers):
            now_kib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            found.grown_mib = round((now_kib - (warm_kib or now_kib)) / 1024, 1)
            found.seconds = round(time.monotonic() - began_s, 1)
            tell(name, found)
    if found.grown_mib > GROWTH_MIB:
        found.faults.append(f'{name}: the process grew by {found.grown_mib:.0f} MiB')
    return found


def tell(name: str, found: Findings) -> None:
    """Print the progress, and write it to the file beside the results of the other kind."""
    print(json.dumps({'what': name, **vars(found)}), flush=True)
    known = json.loads(RESULTS.read_text('utf-8')) if RESULTS.is_file() else {}
    RESULTS.write_text(json.dumps({**known, name: vars(found)}, indent=2) + '\n', 'utf-8')


def _hang(number: int, frame: FrameType | None) -> None:
    del number, frame
    raise HangError(f'more than {LIMIT_S} s of CPU time')


def main() -> int:
    """Mutate, read, and print the outcome."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--count', type=int, default=1_000_000, help='inputs of each kind')
    parser.add_argument('--first', type=int, default=0, help='number of the first input')
    parser.add_argument('--what', nargs='+', choices=KINDS, default=KINDS)
    parser.add_argument('--seed', type=int, default=1727)
    kept = Path(tempfile.gettempdir()) / 'tauto_fuzz'
    parser.add_argument('--keep', type=Path, default=kept)
    asked = parser.parse_args()
    signal.signal(signal.SIGPROF, _hang)
    faults: list[str] = []
    with tempfile.TemporaryDirectory(prefix='tauto_fuzz_') as temporary:
        folder = Path(temporary)
        for scene, duration in SCENES.items():
            sail(load_scene(scene, duration=duration), folder / scene)
        for what in asked.what:
            change, read, where = KINDS[what]
            place = _SHIPPED if what == 'scene' else folder
            seeds = [file.read_bytes() for file in sorted(place.glob(where))]
            made = partial(changed, change, seeds, asked.seed)
            numbers = range(asked.first, asked.first + asked.count)
            faults += fuzz(what, partial(read, folder), made, numbers, asked.keep).faults
    print('\n'.join(faults))
    return 1 if faults else 0


if __name__ == '__main__':
    sys.exit(main())

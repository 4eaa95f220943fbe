"""Mutated files, messages and command lines: they are refused or read, without a crash or hang.

    .venv/bin/python benchmarks/fuzz.py [--count 1000000] [--first 0] [--what mcap index …]

Every input is a valid one with a few changes: bits, bytes and numbers, pieces removed, repeated
or exchanged, for texts also values and keys. Input k of a --seed is always the same. An input
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
from contextlib import chdir, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import FrameType

from typer.testing import CliRunner

import tauto_core
from tauto_core.bags import check_bag, read_bag
from tauto_core.cli.app import app
from tauto_core.samples import SHIP_IMU
from tauto_core.scene import load_scene, parse_scene
from tauto_core.scene.errors import TautoError
from tauto_core.scene.loader import _SHIPPED
from tauto_core.voyage import sail
from tauto_nodes import NodesError
from tauto_nodes.simulation import credits as control

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


LOGS = {
    'ours.csv': 'passage,utc,latitude,longitude,wind_mps,wind_from_deg\n'
    + ''.join(f'p,1790-01-{d:02}T12:00,{10 + d / 2},{-20 - d / 2},8,90\n' for d in range(1, 29)),
    'cliwoc.csv': 'YR,MO,DY,HR,LAT,LON,ID,D,W,ShipName,Nationality,VoyageFrom,VoyageTo\n'
    + ''.join(f'1790,1,{d},1200,{1000 + 50 * d},33000,7,90,80,S,F,A,B\n' for d in range(1, 29)),
    'track.gpx': '<?xml version="1.0"?><gpx version="1.1"><trk><name>t</name><trkseg>\n'
    + ''.join(
        f'<trkpt lat="{40 + h / 10}" lon="-{20 + h / 10}">\n'
        f'<time>2024-05-01T{h:02}:00:00Z</time>\n</trkpt>\n'
        for h in range(24)
    )
    + '</trkseg></trk></gpx>\n',
}
"""A log-book of each form."""


def read_log(folder: Path, data: bytes) -> None:
    """List the passages of a log-book, in the form that its beginning shows."""
    file = folder / ('mutated.gpx' if data[:64].lstrip().startswith(b'<') else 'mutated.csv')
    file.write_bytes(data)
    tauto_core.logbook(file)


KEY = b'of the graph'


def read_control(folder: Path, data: bytes) -> None:
    """Read a message as each one of the graph's own, as it comes and with the mark it needs."""
    del folder
    text = data[8:].partition(b'\0')[0].rpartition(b' ')[0]
    packed = data[16 + control.MARK :]
    for topic, read in (
        (control.CREDIT_TOPIC, control.Report.from_octets),
        (control.END_TOPIC, control.End.from_octets),
    ):
        sealed = data[:8] + text + b' ' + control.mark(KEY, topic, text).hex().encode() + b'\0'
        for octets in (data, sealed):
            with suppress(control.ForeignMessageError):
                read(octets, KEY)
    sealed = data[:16] + control.mark(KEY, SHIP_IMU, packed) + packed
    for octets in (data, sealed):
        with suppress(control.ForeignMessageError):
            control.unpack(KEY, SHIP_IMU, octets)


LINES = [
    'scene check ideal', 'scene check ideal --json', 'scene new --out new.yaml --ship sea',
    'sail ideal --duration 60 --out bag --force', 'sail measured --duration 2 --json',
    'cam involute_weight_at_sea --plate --dxf plate.dxf', 'cam ideal --json --points 5',
    'isochronism ideal --amplitudes 0.1,0.3', 'isochronism globe_in_oil --amplitudes 0.1 --json',
    'design --period 1 --inertia 4e-4 --pull 3.158',
    'axle --depth 0.01 --gyration-radius 0.2 --release-tilt 0.1',
    'altitudes --altitudes 33.75,52.48,62.56 --times 0,7200,14400 --latitude 47', 'hull --json',
    'logbook ours.csv', 'logbook ours.csv --passage p --out new.yaml', 'replay measured --json',
    'bag check measured --json', 'bag recover measured --out new', 'plot ideal phase',
    'euler --json', 'budget measured --json --duration 2', 'scenes --json', '--version',
]  # fmt: skip
WORDS = [
    '-1', '0', '1e-300', 'nan', 'inf', '-inf', '1e400', '', ' ', '-', '--', '\u0661', 'x' * 5000,
    'ideal', 'measured', 'bag', 'ours.csv', 'mutated.yaml', '/', '..', '/dev/null', 'no/such', '~',
    '--json', '--force', '--out', '--set', '--seed', '--duration', '--help', '--plot', '--quiet',
    'a=b', 'ship=', 'ship.rate=1e9', 'trochlea.cam.kind=x', 'clock={}', 'seed=[', 'a.b.c.d=1',
    'x.svg', 'x.png', '/no/x.svg', '0.1,nan', '1,', 'ideal=1', '5 m', '3 parsec',
]  # fmt: skip


def mutated_line(rng: random.Random, seeds: Sequence[bytes]) -> bytes:
    """Return a command line with words replaced, removed, repeated or put in; NUL between them."""
    del seeds
    words = rng.choice(LINES).split()
    for _ in range(rng.randint(1, 3)):
        at = rng.randrange(len(words) + 1)
        words[at : at + rng.randrange(2)] = rng.sample(WORDS, rng.randrange(3))
    return '\0'.join(words).encode('utf-8', 'surrogateescape')


def read_line(folder: Path, data: bytes) -> None:
    """Run a command: it ends with 0, 1 or 2, and with at most ten lines about an error."""
    words = data.decode('utf-8', 'surrogateescape').split('\0')
    with chdir(folder):
        run = CliRunner().invoke(app, words)
    if isinstance(run.exception, OSError) and run.exception.filename is not None:
        raise TautoError(str(run.exception))  # `tauto` prints it in one line
    if run.exception is not None and not isinstance(run.exception, SystemExit):
        raise run.exception
    lines = run.stderr.strip().count('\n') + 1
    assert run.exit_code in (0, 1, 2), f'exit code {run.exit_code}'
    assert not run.exit_code or lines <= 10 or 'Usage' in run.stderr, f'{lines} lines'
    if run.exit_code:
        raise TautoError(run.stderr[:80])


KINDS = {
    'mcap': (mutated, read_mcap, '*/*.mcap'),
    'index': (mutated_index, read_mcap, '*/*.mcap'),
    'metadata': (mutated_scene, read_metadata, 'ideal/metadata.yaml'),
    'scene': (mutated_scene, read_scene, '*.yaml'),
    'log': (mutated_scene, read_log, '*.[cg][sp][vx]'),
    'control': (mutated, read_control, 'control/*'),
    'line': (mutated_line, read_line, 'ours.csv'),
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
        except (TautoError, NodesError):
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
        for file, text in LOGS.items():
            (folder / file).write_text(text)
        (folder / 'control').mkdir()
        report = control.Report('recorder', {SHIP_IMU: 3}, (SHIP_IMU,), True, 7)
        pack = b''.join(control.pack(KEY, SHIP_IMU, [b'x' * 320, b'y' * 324], 5))
        end = control.End('ship_motion', {SHIP_IMU: 3})
        for number, octets in enumerate((report.to_octets(KEY), end.to_octets(KEY), pack)):
            (folder / 'control' / str(number)).write_bytes(octets)
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

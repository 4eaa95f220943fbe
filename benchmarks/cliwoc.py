"""CLIWOC's full file, 280,280 rows, in each of its forms: how long `tauto logbook` takes.

    .venv/bin/python benchmarks/cliwoc.py [ROWS]

The rows are made up, as wide as those of the releases, and many lie on land. The exit code
is 1 if a form takes more than 30 s of a processor for 280,280 rows.
"""

from __future__ import annotations

import contextlib
import io
import json
import random
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from datetime import date, timedelta
from pathlib import Path

ROWS = 280_280
MOST_S = 30.0

Row = tuple[int, int, date, float, float, int, int]
"""Number, log, day, latitude and longitude [degrees], wind from [degrees], wind [0.1 m/s]."""


def rows(count: int) -> Iterator[Row]:
    """Yield rows of logs of 20 to 140 noons, each on a straight way between 55° S and 60° N."""
    drawn = random.Random(1)
    number = log = 0
    while number < count:
        log += 1
        first = date(1750, 1, 1) + timedelta(days=drawn.randint(0, 36_000))
        place = [drawn.uniform(-30.0, 45.0), drawn.uniform(-60.0, 0.0)]
        made = drawn.uniform(-1.0, 1.0), drawn.uniform(-1.0, 1.0)
        for day in range(min(drawn.randint(20, 140), count - number)):
            wind = drawn.choice((270, 90, 10, 362)), drawn.choice((0, 26, 46, 67, 93, 123))
            yield number, log, first + timedelta(days=day), place[0], place[1] % 360.0, *wind
            place = [max(-55.0, min(60.0, place[0] + made[0])), place[1] + made[1]]
            number += 1


def release_21(path: Path, count: int) -> None:
    """Write a table of release 2.1."""
    names = 'YR,MO,DY,HR,LAT,LON,ID,C1,D,W,AT,ShipName,Nationality,VoyageFrom,VoyageTo'
    with path.open('w') as file:
        file.write('\t'.join([*names.split(','), *(f'X{each}' for each in range(124))]) + '\n')
        for _, log, day, north, east, wind_from, wind in rows(count):
            place = f'{round(100 * north)}\t{round(100 * east)}'
            when = f'{day.year}\t{day.month}\t{day.day}\t1300'
            words = f'SHIP {log}\tFrench\tBREST\tKAAP'
            cells = f'{when}\t{place}\t{log}\tFR\t{wind_from}\t{wind}\tNA\t{words}'
            file.write(cells + '\tNA' * 124 + '\n')


def archive(path: Path, count: int) -> None:
    """Write the text of the archive: the core, and the attachment of release 2.1."""
    with path.open('w') as file:
        for _, log, day, north, east, wind_from, wind in rows(count):
            when = f'{day.year}{day.month:2d}{day.day:2d}1300'
            line = f'{when}{round(100 * north):5d}{round(100 * east) % 36_000:6d} 0106    10'
            line = f'{line:34}{log:09d}FR {wind_from:3d}5{wind:3d}'
            named = f'SHIP {log}'
            ports = f'{"BREST":45}{"KAAP":50}'
            file.write(f'{line:705}{named:30}{"French":8}{"":214}{ports}{"":100}\n')


def release_15(path: Path, count: int) -> None:
    """Write a table of release 1.5, with tables of its words beside it."""
    names = 'ShipName,VoyageIni,LogbookIdent,UTC,Lat3,Lon3,WindDirection,WindForce,VoyageTo'
    with path.open('w') as file:
        file.write(','.join([names, *(f'X{each}' for each in range(132))]) + '\n')
        for _, log, day, north, east, wind_from, wind in rows(count):
            words = 'Ouest' if wind_from == 270 else 'Variable', 'frais' if wind else 'calme'
            place = f'{north:.4f},{(east + 180.0) % 360.0 - 180.0:.4f}'
            cells = f'SHIP {log},17500101,{log},{day:%Y%m%d}13,{place},{",".join(words)},KAAP'
            file.write(cells + ',NA' * 132 + '\n')
    forces, ways = 'WindForce,mps\nFRAIS,6.7\nCALME,0\n', 'Ouest,270\nVariable,362\n'
    path.with_name('Lookup_FR_WindForce.csv').write_text(forces)
    path.with_name('Lookup_FR_WindDirection.csv').write_text(f'WindDirection,ProbWindDD\n{ways}')


FORMS: dict[str, Callable[[Path, int], None]] = {
    'release 2.1': release_21,
    'archive': archive,
    'release 1.5': release_15,
}


def listed(path: str) -> dict[str, float]:
    """Return processor time [s], memory [MiB] and passages of `tauto logbook PATH --json`."""
    from tauto_core.cli.app import app

    before, began = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.suppress(SystemExit):
        app(['logbook', path, '--json'])
    took_s = time.process_time() - began
    more = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024.0
    passages = len(json.loads(said.getvalue())['passages'])
    return {'took_s': took_s, 'more_mib': more, 'passages': passages}


def main() -> int:
    if sys.argv[1:2] == ['--list']:
        print(json.dumps(listed(sys.argv[2])))
        return 0
    count, slow = int(sys.argv[1]) if sys.argv[1:] else ROWS, False
    with tempfile.TemporaryDirectory() as folder:
        for form, write in FORMS.items():
            path = Path(folder) / 'cliwoc.txt'
            write(path, count)
            command = [sys.executable, __file__, '--list', str(path)]
            found = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
            size = path.stat().st_size / 2**20
            print(
                f'{form:12} {count} rows, {size:.0f} MiB: {found["passages"]:.0f} passages in '
                f'{found["took_s"]:.1f} s of a processor, {found["more_mib"]:.0f} MiB more'
            )
            slow |= found['took_s'] > MOST_S * count / ROWS
    return int(slow)


if __name__ == '__main__':
    sys.exit(main())

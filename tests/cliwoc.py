"""A long table of a log-book as wide as CLIWOC's, with made-up rows, many of them on land."""

from __future__ import annotations

import random
from datetime import date, timedelta
from pathlib import Path


def release_21(path: Path, count: int) -> None:
    """Write a table of release 2.1: logs of 20 to 140 noons, each on a straight way."""
    names = 'YR,MO,DY,HR,LAT,LON,ID,C1,D,W,AT,ShipName,Nationality,VoyageFrom,VoyageTo'
    drawn, log, number = random.Random(1), 0, 0
    with path.open('w') as file:
        file.write('\t'.join([*names.split(','), *(f'X{each}' for each in range(124))]) + '\n')
        while number < count:
            log += 1
            day = date(1750, 1, 1) + timedelta(days=drawn.randint(0, 36_000))
            north, east = drawn.uniform(-30.0, 45.0), drawn.uniform(-60.0, 0.0)
            made = drawn.uniform(-1.0, 1.0), drawn.uniform(-1.0, 1.0)
            for _ in range(min(drawn.randint(20, 140), count - number)):
                wind_from = drawn.choice((270, 90, 10, 362))
                wind = drawn.choice((0, 26, 46, 67, 93, 123))
                place = f'{round(100 * north)}\t{round(100 * (east % 360.0))}'
                when = f'{day.year}\t{day.month}\t{day.day}\t1300'
                words = f'SHIP {log}\tFrench\tBREST\tKAAP'
                cells = f'{when}\t{place}\t{log}\tFR\t{wind_from}\t{wind}\tNA\t{words}'
                file.write(cells + '\tNA' * 124 + '\n')
                north, east = max(-55.0, min(60.0, north + made[0])), east + made[1]
                day += timedelta(days=1)
                number += 1

"""A small log-book and clocks for tests of trials."""

from pathlib import Path

from tauto_core.scene import load_scene

HEADER = 'passage,nation,ship,from,to,utc,latitude,longitude,wind_from_deg,wind_mps,air_celsius\n'
LOG = f"""{HEADER}\
17700101-1,French,La Une,Brest,Cadiz,1770-01-01T12:00,48.0,-6.0,270,9.3,
17700101-1,French,La Une,Brest,Cadiz,1770-01-02T12:00,46.5,-8.0,200,6.7,
17700101-1,French,La Une,Brest,Cadiz,1770-01-03T12:00,45.0,-9.5,,0,
17700101-2,French,La Deux,Brest,Lisbon,1770-01-01T12:00,48.05,-6.0,260,6.7,
17700101-2,French,La Deux,Brest,Lisbon,1770-01-02T12:00,46.55,-8.0,190,6.7,
17700101-2,French,La Deux,Brest,Lisbon,1770-01-03T12:00,45.05,-9.5,90,1,
17910701-3,Spanish,El Tres,Lima,,1791-07-01T18:00,-12.5,-78.0,150,4.6,
17910701-3,Spanish,El Tres,Lima,,1791-07-02T18:00,-13.0,-80.0,,,
17910701-3,Spanish,El Tres,Lima,,1791-07-03T18:00,-13.5,-82.0,160,4.6,
17910701-3,Spanish,El Tres,Lima,,1791-07-04T18:00,-13.5,-84.0,160,4.6,
"""
CLOCK = 'second_cam_at_sea'
OTHER = 'involute_weight_at_sea'


def write_log(folder: Path, text: str = LOG) -> str:
    """Write a log-book; return its path."""
    path = folder / 'log.csv'
    path.write_text(text)
    return str(path)


def clock(name: str = CLOCK):
    """Return a clock that sails fast: few samples, and few readings."""
    return load_scene(name, **{'log.interval': 600.0, 'ship.rate': 8.0})

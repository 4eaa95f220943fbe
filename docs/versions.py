"""Add the built site to a folder of versions: python docs/versions.py FOLDER [--site site].

FOLDER/VERSION/ is replaced by the site, and FOLDER/versions.json lists what is there, newest
release first, as the theme's switch of versions reads it (the form of mike, which works with
MkDocs alone). FOLDER/index.html leads to the newest release, or where there is none to the version
in work. FOLDER is what a web server shows.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from pathlib import Path

from packaging.version import Version

from tauto_core.version import BASE

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Tauto</title>
<meta http-equiv="refresh" content="0; url={newest}/index.html"></head>
<body><a href="{newest}/index.html">Tauto {newest}</a></body></html>
"""


def add(site: Path, folder: Path, name: str) -> None:
    """Copy a site into the folder as a version, and renew the list and the page that leads on."""
    if not (site / 'index.html').is_file():
        sys.exit(f'docs/versions.py: --site {site}: has no index.html. Build it with make docs')
    if (folder / name).exists():
        shutil.rmtree(folder / name)
    shutil.copytree(site, folder / name)
    found = sorted(
        (Version(each.parent.name) for each in folder.glob('*/index.html')), reverse=True
    )
    newest = next((each for each in found if not each.is_devrelease), found[0])
    versions = [
        {
            'version': str(each),
            'title': f'{each} (in work)' if each.is_devrelease else str(each),
            'aliases': ['latest'] if each == newest else [],
        }
        for each in sorted(found, key=lambda each: (not each.is_devrelease, each), reverse=True)
    ]
    (folder / 'versions.json').write_text(json.dumps(versions, indent=1) + '\n', encoding='utf-8')
    (folder / 'index.html').write_text(PAGE.format(newest=newest), encoding='utf-8')


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=(__doc__ or '').partition('\n')[0])
    parser.add_argument('folder', type=Path)
    parser.add_argument('--site', type=Path, default=Path('site'))
    asked = parser.parse_args()
    add(asked.site, asked.folder, BASE)

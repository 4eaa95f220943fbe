"""The core does not import ROS, neither at the top of a module nor inside a function."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

CORE = Path(__file__).parents[1] / 'src' / 'tauto_core' / 'tauto_core'
WELCOME = {
    'allantools',
    'bokeh',
    'build123d',
    'capytaine',
    'distributed',
    'ezdxf',
    'geographiclib',
    'llvmlite',
    'loky',
    'gpxpy',
    'h5netcdf',
    'h5py',
    'lz4',
    'matplotlib',
    'PIL',
    'mcap',
    'numpy',
    'pandas',
    'pyarrow',
    'pydantic',
    'pydantic_core',
    'rich',
    'rosbags',
    'scipy',
    'tauto_core',
    'typer',
    'wavespectra',
    'xarray',
    'yaml',
    'zstandard',
}


def imports(source: str) -> set[str]:
    """Return the top-level names of all modules that a source imports, wherever it does."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found.add(str(node.module))
    return {name.partition('.')[0] for name in found}


def test_an_import_inside_a_function_is_found() -> None:
    assert imports('def f():\n    from rclpy.node import Node\n    import a.b') == {'rclpy', 'a'}


@pytest.mark.parametrize(
    'module', sorted(CORE.rglob('*.py')), ids=lambda path: str(path.relative_to(CORE))
)
def test_core_imports_only_what_its_setup_names(module: Path) -> None:
    foreign = imports(module.read_text(encoding='utf-8')) - WELCOME - set(sys.stdlib_module_names)
    assert not foreign


def test_tests_share_modules_by_names_that_no_library_has() -> None:
    """Some libraries install a package `tests`, which Python takes before a folder of ours."""
    for file in Path(__file__).parent.rglob('*.py'):
        assert 'tests' not in imports(file.read_text('utf-8')), file

"""The core does not import ROS, and no files import each other in a circle."""

from __future__ import annotations

import ast
import re
import sys
from pathlib import Path

import pytest

SRC = Path(__file__).parents[1] / 'src'
CORE = SRC / 'tauto_core' / 'tauto_core'
WELCOME = {
    *('allantools', 'build123d', 'capytaine', 'ezdxf', 'geographiclib', 'gpxpy', 'h5netcdf'),
    *('h5py', 'llvmlite', 'loky', 'lz4', 'matplotlib', 'mcap', 'numpy', 'pandas', 'PIL'),
    *('pyarrow', 'pydantic', 'pydantic_core', 'rich', 'rosbags', 'scipy', 'tauto_core'),
    *('typer', 'xarray', 'yaml', 'zstandard'),
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


def modules() -> dict[str, Path]:
    """Return the files of both packages by the names under which they are imported."""
    found = {}
    for package in (CORE, SRC / 'tauto_nodes' / 'tauto_nodes'):
        for file in package.rglob('*.py'):
            parts = file.relative_to(package.parent).with_suffix('').parts
            found['.'.join(parts[:-1] if parts[-1] == '__init__' else parts)] = file
    return found


def graph(sources: dict[str, str]) -> dict[str, set[str]]:
    """Return which modules each module imports: at the top, in functions, for types alone."""
    edges: dict[str, set[str]] = {}
    for name, source in sources.items():
        edges[name] = set()
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Import):
                edges[name] |= {alias.name for alias in node.names} & sources.keys()
            elif isinstance(node, ast.ImportFrom):
                assert not node.level, f'{name} has a relative import'
                each = {f'{node.module}.{alias.name}' for alias in node.names}
                # the package itself is imported where a name is not one of its modules
                edges[name] |= (each & sources.keys()) | (
                    {str(node.module)} & sources.keys() if each - sources.keys() else set()
                )
        edges[name].discard(name)
    return edges


def circles(edges: dict[str, set[str]]) -> set[frozenset[str]]:
    """Return the sets of modules that reach each other."""

    def reached(start: str) -> set[str]:
        found: set[str] = set()
        left = [start]
        while left:
            new = edges[left.pop()] - found
            found |= new
            left += new
        return found

    far = {name: reached(name) for name in edges}
    return {
        frozenset(each for each in far[name] if name in far[each])
        for name in edges
        if name in far[name]
    }


def test_circles_run_through_functions_and_types() -> None:
    found = graph(
        {
            'p': 'from p.a import x',
            'p.a': 'def f():\n    from p import b',
            'p.b': 'if TYPE_CHECKING:\n    import p.c',
            'p.c': 'from p.a import x',
            'p.d': 'from p.c import y',
        }
    )
    assert circles(found) == {frozenset({'p.a', 'p.b', 'p.c'})}


def test_no_files_import_each_other_in_a_circle() -> None:
    sources = {name: file.read_text('utf-8') for name, file in modules().items()}
    assert not circles(graph(sources))


WRITES = re.compile(r"""\.write_(?:text|bytes)\(|open\([^)]*['"][wax]b?['"]|FileIO\(|O_WRONLY""")


def test_results_are_written_by_two_writers_alone() -> None:
    """Those of `files` and of bags, which faults of the disk at each call are tried on."""
    writers = {
        str(file.relative_to(CORE))
        for file in CORE.rglob('*.py')
        if WRITES.search(file.read_text('utf-8'))
    }
    # the cache of kernels has its own tests; the schema is a part of the package; /dev/null
    others = {'kernels/entries.py', 'scene/reference.py', 'cli/terminal.py'}
    assert writers == {'files.py', 'bags/write.py', *others}

"""Modules of files that lie in no package, such as docs/trial.py, and programs."""

import importlib.util
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any


def module_of(path: Path) -> ModuleType:
    """Run a file; return its module, which other imports find under the file's name."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    return module


def run_program(*words: str | Path, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run a program to its end; return its exit code and its output."""
    options = {'timeout': 600.0, **options}
    return subprocess.run(words, capture_output=True, text=True, check=False, **options)

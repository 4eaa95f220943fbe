"""Settings for all tests."""

import signal

import pytest
from hypothesis import settings

# How long an example takes depends on the machine and on what must be compiled first.
settings.register_profile('tauto', deadline=None)
settings.load_profile('tauto')

# Below nohup it is ignored, by all children, and tests that send it would wait for ever.
signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.fixture
def short_trials(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let checks of scenes try a small part of each, where its errors are not asked for."""
    monkeypatch.setattr('tauto_core.checks.cost.TRIAL_RUN_S', 0.01)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put files that start programs of their own first: those take long, in few tests.

    A worker that began one of them at the end would keep the others waiting.
    """
    items.sort(key=lambda item: not _starts_programs(item))


def _starts_programs(item: pytest.Item) -> bool:
    return item.path.name.startswith('test_house') or item.path.parent.name == 'nodes'

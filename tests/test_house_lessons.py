"""The lessons run as they are, show their pictures, and are kept without outputs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

LESSONS = sorted((Path(__file__).parents[1] / 'docs' / 'lessons').glob('*.ipynb'))
PICTURES = {'equal_swings': 3, 'rating_a_clock': 3, 'what_the_sea_takes': 3}


@pytest.mark.parametrize('lesson', LESSONS, ids=lambda file: file.stem)
@pytest.mark.filterwarnings('default')  # those of Jupyter, in its own modules
def test_a_lesson_runs_and_shows_its_pictures(lesson: Path, tmp_path: Path) -> None:
    for library in ('nbclient', 'ipykernel'):
        pytest.importorskip(library, reason='the extra `notebook` is not installed')
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(lesson, as_version=4)
    resources = {'metadata': {'path': str(tmp_path)}}
    NotebookClient(notebook, timeout=600, kernel_name='python3', resources=resources).execute()
    outputs = [each for cell in notebook.cells for each in cell.get('outputs', ())]
    assert not [each.text for each in outputs if each.get('name') == 'stderr']
    data = [each.data for each in outputs if 'data' in each]
    shown = ['image/png' in each or '<img' in each.get('text/html', '') for each in data]
    assert sum(shown) == PICTURES[lesson.stem]
    assert not list(tmp_path.iterdir())


def test_lessons_have_no_outputs_and_a_page_leads_to_each() -> None:
    assert {each.stem for each in LESSONS} == set(PICTURES)
    index = (LESSONS[0].parents[1] / 'howto' / 'python.md').read_text(encoding='utf-8')
    for lesson in LESSONS:
        content = json.loads(lesson.read_text(encoding='utf-8'))
        assert f'(../lessons/{lesson.name})' in index
        for cell in content['cells']:
            assert not cell.get('outputs')
            assert cell.get('execution_count') is None

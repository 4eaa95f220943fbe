"""`tauto euler`: the claims as text and as JSON, and the exit code."""

from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.euler import fluid_1729
from tauto_core.euler.page import all_claims


def test_json_holds_every_claim_in_order() -> None:
    result = CliRunner().invoke(app, ['euler', '--json'])
    assert result.exit_code == 0, result.stderr
    printed = json.loads(result.stdout)['claims']
    claims = all_claims()
    assert [each['claim'] for each in printed] == [claim.said for claim in claims]
    assert [each['paper'] for each in printed] == sorted(each['paper'] for each in printed)
    for each, claim in zip(printed, claims, strict=True):
        assert each['verdict'] == claim.expected
        assert each['computed'] == claim.computed
        assert (each['value'] is None) == math.isnan(claim.value)
        assert bool(each['because']) == (claim.verdict in {'corrected', 'answered'})
        assert bool(each['whose']) == (claim.verdict == 'corrected')
        assert (each['stands'] is None) <= (each['adds'] is not None)


def test_the_words_keep_corrections_and_reasons(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('COLUMNS', '70')
    result = CliRunner().invoke(app, ['euler'])
    assert result.exit_code == 0, result.stderr
    assert max(map(len, result.stdout.splitlines())) <= 70
    text = ' '.join(result.stdout.split())
    count = Counter(claim.verdict for claim in all_claims())
    assert f'claims: {count["holds"]} hold as they stand, {count["corrected"]} once cor' in text
    assert 'none were compared' in text
    for claim in all_claims():
        assert ' '.join(claim.said.split()) in text
        assert ' '.join(claim.reason.split()) in text
        assert ' '.join(claim.must.split()) in text
    assert 'B §23, 31' in text


def test_a_claim_with_another_verdict_is_exit_code_1(monkeypatch: pytest.MonkeyPatch) -> None:
    good = fluid_1729.claims()
    spoilt = [replace(good[0], computed=good[0].computed * 1.01), *good[1:]]
    monkeypatch.setattr(fluid_1729, 'claims', lambda: spoilt)
    result = CliRunner().invoke(app, ['euler', '--json'])
    assert result.exit_code == 1
    assert len(json.loads(result.stdout)['claims']) == len(all_claims())
    assert 'tauto: B §2-5' in result.stderr
    assert 'should be holds' in result.stderr

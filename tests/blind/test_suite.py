"""The small deck, made afresh from an open seed and put before the analyst: does it run, is it silent, does it find?

    python -m pytest -m blind tests/blind/test_suite.py

The figures that judge the method need a whole deck (`python -m tests.blind.run --judge`); 24 cases only show that nothing broke.
"""

import pytest

from . import figures, generate, run, score

pytestmark = [pytest.mark.blind, pytest.mark.slow]


@pytest.fixture(scope="module")
def scored(tmp_path_factory):
    """Figures of the small deck by name."""
    folder = tmp_path_factory.mktemp("blind")
    generate.generate(folder, generate.SMALL_SEED, generate.SMALL)
    problems = run.verdicts(folder / "cases", folder / "verdicts", workers=2, quiet=True)
    print(score.report(folder))
    pairs, _ = score.load(folder, folder / "verdicts")
    return {figure.name: figure for figure in figures.figures(pairs)}, problems


def test_every_case_gets_a_verdict(scored):
    assert not scored[1]


def test_nulls_stay_silent(scored):
    """None of three: the chance of one false alarm at the rate that must hold (5 %) is 14 %, of two below 1 %."""
    figure = scored[0]["false alarm on nulls"]
    assert figure.count >= 3 and figure.hits <= 1


def test_nothing_is_unique_but_wrong(scored):
    """At most one of about ten."""
    assert scored[0]["unique but wrong"].hits <= 1


def test_the_truth_is_among_what_is_reported(scored):
    """At least four fifths of the few strong cases."""
    figure = scored[0]["truth inside the reported set, >= 0.6"]
    assert figure.count and figure.hits >= 0.8 * figure.count

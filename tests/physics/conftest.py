"""What the validation cases share: the fixture that records a figure, and small worlds to measure in."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path[:0] = [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[1] / "benchmarks")]
import case_report  # noqa: E402

PAGE = Path(__file__).resolve().parents[2] / "docs" / "validation.md"
ROWS, MISSES = pytest.StashKey(), pytest.StashKey()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """In a validation run every test of this folder is a validation case, the quick ones too."""
    if "validation" in config.option.markexpr and "not validation" not in config.option.markexpr:
        for item in items:
            if item.path.parent == Path(__file__).resolve().parent:
                item.add_marker(pytest.mark.validation)


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem):
    """After the body of a test: fail if a figure missed its target, so that the figures after it are measured too."""
    result = yield
    misses = pyfuncitem.stash.get(MISSES, [])
    if misses:
        unexplained = "\n".join(text for text, reason in misses if not reason)
        if unexplained:
            pytest.fail(unexplained, pytrace=False)
        pytest.xfail("; ".join(f"{text}: {reason}" for text, reason in misses))
    return result


@pytest.fixture
def record_case(request):
    """record_case(case, what, figure, target, unit="", peer="–", reason="") notes a figure and checks it.

    A number is met if its magnitude is at most the target. With target=None `figure` is a truth value, named by `claim`.
    A target that is out of reach has a `reason`: the test is then an expected failure that shows the figure.
    """
    rows = request.config.stash.setdefault(ROWS, [])

    def record(case, what, figure, target=None, unit="", peer="–", reason="", claim="true"):
        if target is None:
            met, shown, limit = bool(figure), "yes" if figure else "no", claim
        else:
            figure = float(figure)
            met, shown, limit = bool(np.abs(figure) <= target), figure, target
        rows.append(case_report.Row(str(case), what, shown, limit, unit, met, peer, reason))
        if not met:
            text = f"case {case}, {what}: {case_report.number(shown)} {unit}, target {limit}"
            request.node.stash.setdefault(MISSES, []).append((text, reason))

    return record


def pytest_terminal_summary(terminalreporter, config):
    """Print the table, and write it to docs/ if the run was the whole validation run."""
    rows = config.stash.get(ROWS, [])
    if config.option.markexpr != "validation" or not rows:
        return
    terminalreporter.section("validation cases")
    for row in sorted(rows, key=case_report.order):
        case, what, figure, limit, met, peer = row.cells()
        terminalreporter.write_line(f"{case:>9}  {what:62} {figure:>16}  {limit:>16}  {'yes' if row.met else 'NO':3}  {peer}")
    broken = [report.nodeid for report in terminalreporter.stats.get("failed", []) + terminalreporter.stats.get("error", [])]
    if not config.option.keyword and not any(".py" in argument for argument in config.args):
        PAGE.parent.mkdir(exist_ok=True)
        PAGE.write_text(case_report.page(rows, broken), encoding="utf-8")
        terminalreporter.write_line(f"written: {PAGE}")

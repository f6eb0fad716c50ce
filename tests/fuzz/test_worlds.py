"""Saved worlds that somebody changed: none crashes the interpreter, hangs or shows a traceback (the short run of ``worlds``)."""

from collections import Counter

from tests.fuzz import worlds


def test_changed_worlds_are_refused_in_one_line_or_step(tmp_path):
    """Sixty mutants of a fixed seed; some must be refused and some must load, or the mutator has lost its aim."""
    found = worlds.run(60, 20, tmp_path)
    counts = Counter(what.split()[0] for _, what in found)
    bad = [row for row in found if row[1].split()[0] in ("traceback", "crash", "hang")]
    assert not bad and sum(counts.values()) == 60
    assert counts["refused"] > 20 and counts["stepped"] > 0
    assert all("world file" in what and "\\n" not in what for _, what in found if what.startswith("refused"))

"""A short run of the mutants; the long one is a command, see `tests.fuzz.tomls`."""

from pathlib import Path

import pytest

from minibullet.errors import InputError
from tests.fuzz import tomls


def test_every_mutant_is_read_or_refused_in_one_line():
    counts, bad = tomls.run(400, seed=1)
    assert not bad
    assert counts["read"] > 20 and counts["refused"] > 200  # else they say nothing of what works, or of what does not


def test_the_files_they_are_made_of_are_read(tmp_path):
    for name, text in tomls.DATA.items():
        (tmp_path / name).write_text(text)
    for kind, text in tomls.BASES.items():
        (tmp_path / "base.toml").write_text(text)
        assert tomls.outcome(kind, tmp_path / "base.toml") == ("read", "")


def test_a_fault_of_the_reader_and_a_hang_are_seen(tmp_path, monkeypatch):
    """The fuzzer itself: what it is there to find, it finds."""
    monkeypatch.setattr(tomls, "LONGEST", 0.05)
    for fault, found in ((lambda *_: 1 / 0, "traceback"), (lambda *_: [None for _ in iter(int, 1)], "hang")):
        monkeypatch.setattr(tomls, "read", fault)
        assert tomls.outcome("sweep", tmp_path / "x.toml")[0] == found
    monkeypatch.setattr(tomls, "read", lambda *_: (_ for _ in ()).throw(InputError("two\nlines")))
    assert tomls.outcome("sweep", tmp_path / "x.toml")[0] == "traceback"


@pytest.mark.parametrize("number", range(3))
def test_a_mutant_is_the_same_whenever_it_is_made(number):
    assert tomls.mutant("sweep", number) == tomls.mutant("sweep", number) != tomls.mutant("sweep", number + 1)


def test_mutants_are_kept_where_they_are_asked_for(tmp_path, monkeypatch):
    monkeypatch.setattr(tomls, "outcome", lambda *_: ("traceback", "words"))
    _, bad = tomls.run(1, keep=tmp_path)
    assert bad == [("layers", 0, "words")] and Path(tmp_path, "layers_0.toml").read_bytes() == tomls.mutant("layers", 0)

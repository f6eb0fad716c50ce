"""The packaged data sets: readable, small, silent about their answers, and made again bit for bit."""

import tomllib

import numpy as np
import pytest
from numba import config as numba_config

from hlcs import mystery
from minibullet.errors import InputError

from .remake_mysteries import RECIPES, make

compiled = pytest.mark.skipif(bool(numba_config.DISABLE_JIT), reason="millions of steps: only with compiled kernels")


def test_there_are_sets_from_easy_to_hard():
    """One effect first, two at the end, the last with one that no library has; among them one where nothing is missing."""
    assert len(mystery.names()) >= 8 and mystery.names() == tuple(recipe.name for recipe in RECIPES)
    answers = [mystery.answer(name) for name in mystery.names()]
    assert len(answers[0]["effects"]) == 1 and len(answers[-1]["effects"]) == 2 and answers[-1]["outside"]
    assert any(not answer["effects"] for answer in answers)


@pytest.mark.parametrize("name", mystery.names())
def test_set_is_whole_and_tells_nothing(name, tmp_path):
    """The copy is an experiment of the contract with rising times; no hidden effect is named in name, title or file."""
    experiment = tomllib.loads(mystery.copy(name, tmp_path / "new").read_text(encoding="utf-8"))
    assert experiment["title"] == mystery.title(name) and not (tmp_path / "new" / mystery.SEALED).exists()
    for trial in experiment["trial"]:
        rows = np.genfromtxt(tmp_path / "new" / trial["file"], delimiter=",", names=True)
        assert (np.diff(rows["t_s"]) > 0).all()
    assert len({trial["group"] for trial in experiment["trial"]}) >= 2
    text = name + (tmp_path / "new" / "experiment.toml").read_text(encoding="utf-8")
    for effect in mystery.answer(name)["effects"]:
        assert f'"{effect}"' not in text and effect not in name + mystery.title(name) and effect in mystery.reveal(name)
    mystery.copy(name, tmp_path / "new")  # the same files again are no offence


def test_wrong_names_and_foreign_files_are_refused(tmp_path):
    with pytest.raises(InputError, match="nearest name is 'tower-drop'"):
        mystery.copy("towerdrop", tmp_path)
    (tmp_path / "experiment.toml").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="other content"):
        mystery.copy("tower-drop", tmp_path)
    assert (tmp_path / "experiment.toml").read_text(encoding="utf-8") == "mine"


def test_all_sets_together_stay_small():
    assert sum(file.stat().st_size for file in mystery.FOLDER.rglob("*") if file.is_file()) < 500_000


def remade(number):
    """Whether a set comes out as it is packaged."""
    folder = mystery.FOLDER / RECIPES[number].name
    files = make(RECIPES[number], number)
    assert sorted(files) == sorted(file.name for file in folder.iterdir())
    for name, text in files.items():
        assert (folder / name).read_bytes() == text.encode("utf-8"), name


@compiled
def test_a_set_is_made_again_bit_for_bit():
    """One set in the quick run: the empty one needs no search."""
    remade([recipe.deal.kind for recipe in RECIPES].index("null"))


@compiled
@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(RECIPES)))
def test_every_set_is_made_again_bit_for_bit(number):
    remade(number)

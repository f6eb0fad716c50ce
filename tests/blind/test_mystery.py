"""The packaged data sets: readable, small, silent about their answers, and made again bit for bit."""

import tomllib

import numpy as np
import pytest
from numba import config as numba_config

from hlcs import mystery
from hlcs.mystery import layers
from minibullet.errors import InputError

from .remake_mysteries import RECIPES, by_room, from_pybullet, make

compiled = pytest.mark.skipif(bool(numba_config.DISABLE_JIT), reason="millions of steps: only with compiled kernels")


def test_there_are_sets_from_easy_to_hard():
    """Thirteen in three rooms, each from one effect to two or to a set; one where nothing is missing, one with an effect that no
    library has, three that cannot be told apart, one table of outcomes, one of layers."""
    assert mystery.rooms() == {room: tuple(names) for room, names in by_room().items()} and len(mystery.names()) == 13
    assert sorted(mystery.names()) == sorted(recipe.name for recipe in RECIPES)
    answers = {name: mystery.answer(name) for name in mystery.names()}
    for names in mystery.rooms().values():
        hard = answers[names[-1]]
        assert len(answers[names[0]]["effects"]) == 1 and (len(hard["effects"]) == 2 or hard["tied"])
    assert [name for name in answers if not answers[name]["effects"]] == ["empty-gallery"]
    assert [name for name in answers if answers[name]["outside"]] == ["north-window"]
    assert [name for name in answers if answers[name]["tied"]] == ["park-bench", "tall-tank", "quarry-yard"]
    kinds = {name: tomllib.loads(mystery.experiment(name).read_text("utf-8"))["kind"] for name in answers}
    assert [name for name in answers if kinds[name] == "outcomes"] == ["tall-tank"]
    assert [name for name in answers if kinds[name] == "layers"] == ["quarry-yard"]


@pytest.mark.parametrize("name", mystery.names())
def test_set_is_whole_and_tells_nothing(name, tmp_path):
    """The copy is an experiment of the contract with rising times; no hidden effect is named in name, title or file."""
    experiment = tomllib.loads(mystery.copy(name, tmp_path / "new").read_text(encoding="utf-8"))
    assert experiment["title"] == mystery.title(name) and not (tmp_path / "new" / mystery.SEALED).exists()
    if experiment["kind"] != "trajectory":
        rows = np.genfromtxt(tmp_path / "new" / experiment["measurement"]["file"], delimiter=",", names=True, dtype=None)
        groups = set(rows["group" if experiment["kind"] == "outcomes" else "campaign"])
    else:
        for trial in experiment["trial"]:
            rows = np.genfromtxt(tmp_path / "new" / trial["file"], delimiter=",", names=True)
            assert (np.diff(rows["t_s"]) > 0).all()
        groups = {trial["group"] for trial in experiment["trial"]}
    assert len(groups) >= 2
    text = name + (tmp_path / "new" / "experiment.toml").read_text(encoding="utf-8")
    for effect in mystery.answer(name)["effects"]:
        assert f'"{effect}"' not in text and effect not in name + mystery.title(name) and effect in mystery.reveal(name)
    mystery.copy(name, tmp_path / "new")  # the same files again are no offence


def test_wrong_names_and_foreign_files_are_refused(tmp_path):
    with pytest.raises(InputError, match="did you mean 'tower-drop'"):
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
    """Three sets in the quick run: the empty one needs no search, the tables are a closed form and draws from known means."""
    for name in ("empty-gallery", "tall-tank", "quarry-yard"):
        remade([recipe.name for recipe in RECIPES].index(name))


def test_the_layers_of_a_mystery_are_those_that_pybullet_gave():
    """What ships is a cut of the deck's file, not a copy that could drift from it."""
    assert layers.PYBULLET.read_text(encoding="utf-8") == from_pybullet()


@compiled
@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(RECIPES)))
def test_every_set_is_made_again_bit_for_bit(number):
    remade(number)

"""New data sets: what is asked for is hidden, as strongly as asked, and the diagnosis, which shares no code with it, finds it."""

import numpy as np
import pytest

import hlcs
from hlcs import mystery
from hlcs.mystery.making import COARSEST, FINEST, OFFERS, made
from hlcs.mystery.seal import SEALED, opened
from minibullet.errors import InputError

STRENGTH, SEED = 8.0, 1
QUICK = ("clock_offset", "time_scale")  # a second each
# what no recording of that scene can tell from what is hidden: of a block that slides along a level floor to its rest, only the
# deceleration mu (1 + a) g f2 is seen, of the friction mu, an adhesion of a weights and a clock that goes f times too fast
ALIKE = {"friction": {"friction", "adhesion", "time_scale"}}


def found(effect, folder):
    """The diagnosis of a new set names what is hidden, and its number within four times its 90 % interval: 6.6 sigma."""
    diagnosis = hlcs.diagnose(mystery.make(effect, STRENGTH, SEED, folder / "case"))
    assert diagnosis.effects == (effect,), diagnosis.verdict
    assert diagnosis.verdict == ("ambiguous" if diagnosis.ambiguous else "effect")
    assert set().union(*diagnosis.ambiguous) <= ALIKE.get(effect, set())
    for name, true in mystery.answer(folder / "case")["parameters"][effect].items():
        number = diagnosis.parameters[effect][name]
        assert abs(number["value"] - true) < 4 * (number["high"] - number["low"]) / 2, (name, number, true)


@pytest.mark.parametrize("effect", QUICK)
def test_what_is_hidden_is_found(effect, tmp_path):
    found(effect, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("effect", [name for name in OFFERS if name not in QUICK])
def test_whatever_is_hidden_is_found(effect, tmp_path):
    found(effect, tmp_path)


def test_the_same_request_gives_the_same_bytes_and_another_seed_others():
    first = made("rolling_friction", STRENGTH, 3)
    assert made("rolling_friction", STRENGTH, 3) == first
    other = made("rolling_friction", STRENGTH, 4)
    assert other.keys() == first.keys() and all(other[name] != first[name] for name in first if name != "experiment.toml")


@pytest.mark.parametrize("strength", [3.0, 30.0])
def test_strength_is_the_misfit_of_the_model_over_the_noise(strength, tmp_path):
    """The noise adds to it as squares do: sqrt(strength2 + 1). Five per cent: the strength holds to first order in the starts;
    and 800 numbers tell their own noise to 2.5 %."""
    error = hlcs.compare(mystery.make("clock_offset", strength, SEED, tmp_path / "case")).error
    assert error["rms"] / error["noise"] == pytest.approx(np.hypot(strength, 1.0), rel=0.05)
    assert FINEST <= mystery.answer(tmp_path / "case")["noise"]["position"] <= COARSEST


def test_strength_zero_hides_nothing(tmp_path):
    comparison = hlcs.compare(mystery.make("clock_offset", 0, SEED, tmp_path / "case"))
    assert comparison.adequate and mystery.answer(tmp_path / "case")["effects"] == []


def test_files_say_nothing_of_what_is_hidden_but_the_seal():
    for effect in ("quadratic_drag", "rolling_friction"):
        files = made(effect, STRENGTH, SEED)
        assert effect not in "".join(text for name, text in files.items() if name != SEALED)
        answer = opened(files[SEALED].encode())
        assert answer["effects"] == [effect] and answer["made"] == {"effect": effect, "strength": STRENGTH, "seed": SEED}
        law = OFFERS[effect]
        assert all(law.low <= value <= law.high for value in answer["parameters"][effect].values())


@pytest.mark.parametrize(
    ("effect", "strength", "words"),
    [
        ("quadratic_darg", 8, "effect 'quadratic_darg': cannot be hidden; did you mean 'quadratic_drag'?"),
        ("rolling_friction", -1, "strength = -1: must be a number of at least 0"),
        ("rolling_friction", float("nan"), "strength = nan: must be a number"),
        ("rolling_friction", 1e6, "strength = 1e+06: rolling_friction as it is found in nature changes what cameras see by"),
    ],
)
def test_what_cannot_be_made_is_told_in_one_line_and_nothing_is_written(effect, strength, words, tmp_path):
    with pytest.raises(InputError) as told:
        mystery.make(effect, strength, SEED, tmp_path / "case")
    assert str(told.value).startswith(words) and "\n" not in str(told.value) and not list(tmp_path.iterdir())


def test_a_new_set_is_copied_for_students_without_its_answer(tmp_path):
    mystery.make("clock_offset", STRENGTH, SEED, tmp_path / "mine")
    copy = mystery.copy(tmp_path / "mine", tmp_path / "theirs")
    assert copy.read_bytes() == mystery.experiment(tmp_path / "mine").read_bytes()
    assert not (tmp_path / "theirs" / SEALED).exists() and (tmp_path / "theirs" / "rest.csv").exists()
    (tmp_path / "mine" / SEALED).write_text("no seal")
    with pytest.raises(InputError, match="is no sealed answer"):
        mystery.answer(tmp_path / "mine")

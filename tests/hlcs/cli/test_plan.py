"""`hlcs plan`: a table of what is needed, its JSON, and one line for what cannot be planned."""

import json

import pytest
from layer_tables import experiment, measured
from throws import write_throws

DRAG = ("--effect", "quadratic_drag", "--at", "drag_coefficient=0.47")


@pytest.fixture
def throws(tmp_path):
    return str(write_throws(tmp_path, count=2, static=False, noise="noise = { position = 0.004 }"))


def test_what_is_needed_is_printed_and_written(hlcs, throws, tmp_path):
    status, text, _ = hlcs("plan", throws, *DRAG, "--power", "0.8", "--json", "plan.json")
    assert status == 0
    for words in ("Pilot: 2 recordings", "half the noise", "twice as long", "Needed:", "would leave open"):
        assert words in text
    told = json.loads((tmp_path / "plan.json").read_text())
    assert "noncentrality" not in text and f"stands {told['noncentrality'] ** 0.5:.3g} times over the noise" in text
    assert "the root of the sum of squares" in text and "also called power" in text  # what the columns are, where they stand
    assert told["format"] == 1 and told["effect"] == "quadratic_drag" and told["at"] == {"drag_coefficient": 0.47}
    assert told["power"] == 0.8 and set(told["now"]) == {"recordings", "power"}
    assert set(told["needed"]) == {"recordings", "length_s", "sigma", "unit"} and told["needed"]["unit"] == "m"
    assert told["options"] and told["look_alikes"]


def test_what_is_too_small_is_said_to_be_infeasible_with_what_would_do(hlcs, throws):
    _, text, _ = hlcs("plan", throws, "--effect", "quadratic_drag", "--at", "drag_coefficient=0.005")
    assert "Infeasible: more than 1,000 recordings" in text
    assert text.split("Instead: ")[1].startswith("2 recordings, twice as long, with a noise of 0.004 m; or 2 recordings")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--effect", "quadratic_darg", "--at", "drag_coefficient=1"), "the nearest known effect is 'quadratic_drag'"),
        (("--effect", "quadratic_drag", "--at", "drag=1"), "it has drag_coefficient"),
        (("--effect", "quadratic_drag", "--at", "drag_coefficient=inf"), "must be a finite number"),
        (("--effect", "quadratic_drag", "--at", "drag_coefficient"), "write PARAMETER=VALUE"),
        (("--effect", "quadratic_drag"), "--at"),
        (("--effect", "restitution", "--at", "restitution=0.5"), "restitution cannot act in these data"),
        ((*DRAG, "--power", "1.5"), "power = 1.5"),
        ((*DRAG, "--at", "drag_coefficient=0.5"), "--at drag_coefficient is given 2 times; give each number once"),
        (("--effect", "quadratic_drag", "--at", "drag_coefficient=-1"), "its law holds from 0 on"),
    ],
)
def test_what_cannot_be_planned_is_one_line_and_status_2(hlcs, throws, arguments, words):
    status, text, errors = hlcs("plan", throws, *arguments)
    assert (status, text, errors.count("\n")) == (2, "", 1) and words in errors


def test_layers_are_said_not_to_be_offered(hlcs, tmp_path):
    experiment(tmp_path, [measured("TPG", 1, "a")])
    status, text, errors = hlcs("plan", "layers.toml", "--effect", "friction", "--at", "friction=0.4")
    assert (status, text, errors.count("\n")) == (2, "", 1) and "not yet for layers" in errors

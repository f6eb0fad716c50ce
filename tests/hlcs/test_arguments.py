"""A wrong word in Python is refused in one line that names it and the word that was meant, as in files and commands."""

import numpy as np
import pytest

import hlcs
import minibullet as mb
from hlcs.placement.presets import preset

DROP = {"t_s": [0.0, 0.1, 0.2, 0.3], "z_m": [2.0, 1.951, 1.804, 1.559]}
BALL = {"shape": "sphere", "radius": 0.05, "mass": 2.0}


def from_frames(**given):
    return hlcs.Experiment.from_frames([DROP], **{"body": BALL, "noise": {"position": 0.001}} | given)


WRONG = [  # what is called, the wrong word, the one that was meant
    (lambda: hlcs.PlacementTest(frictoin=0.5), "'frictoin'", "friction"),
    (lambda: hlcs.PlacementTest(colums=9), "'colums'", "columns"),
    (lambda: hlcs.PlacementTest(grid="TGP"), "'TGP'", "TPG"),
    (lambda: hlcs.PlacementTest(armour="cubipot"), "'cubipot'", "cubipod"),
    (lambda: hlcs.PlacementTest(shape="peices"), "'peices'", "pieces"),
    (lambda: hlcs.PlacementTest(reference="blnd"), "'blnd'", "blind"),
    (lambda: hlcs.PlacementTest(crowding="trun"), "'trun'", "turn"),
    (lambda: hlcs.PlacementTest(damping_law="per step"), "'per step'", "per_step"),
    (lambda: hlcs.PlacementTest(solver="gauss_siedel"), "'gauss_siedel'", "gauss_seidel"),
    (lambda: hlcs.PlacementTest(bottom="slop:0.04"), "'slop:0.04'", "slope"),
    (lambda: hlcs.TPG.stacked("ACB"), "'ACB'", "ABC"),
    (lambda: hlcs.Grid("mine", 1.5, 1.3, stackin="ABA"), "'stackin'", "stacking"),
    (lambda: hlcs.Cubipod(nominal_diametre=1.0), "'nominal_diametre'", "nominal_diameter"),
    (lambda: hlcs.Cube(side=1.0).shape("peices"), "'peices'", "pieces"),
    (lambda: preset("papr"), "'papr'", "paper"),
    (lambda: hlcs.laboratory("table_2", grid="TPG"), "'table_2'", "table2"),
    (lambda: hlcs.laboratory("table2", grid="TGP"), "'TGP'", "TPG"),
    (lambda: hlcs.paper_numerical("table2", grid="TPG", study="numercal"), "'numercal'", "numerical"),
    (lambda: hlcs.example_unit("tetrapode"), "'tetrapode'", "tetrapod"),
    (lambda: hlcs.mystery.experiment("tower-dorp"), "'tower-dorp'", "tower-drop"),
    (lambda: hlcs.import_measurements("a.csv", "phifox", "out"), "'phifox'", "phyphox"),
    (lambda: hlcs.import_measurements("a.csv", "csv", "out", lenght_unit="cm"), "'lenght_unit'", "length_unit"),
    (lambda: hlcs.import_measurements("a.csv", "csv", "out", length_unit="mn"), "'mn'", "m"),
    (lambda: from_frames(kind="trajectry"), "'trajectry'", "trajectory"),
    (lambda: from_frames(surroundngs={"gravity": 9.81}), "surroundngs", "surroundings"),
    (lambda: from_frames(body={**BALL, "shape": "spere"}), "'spere'", "sphere"),
    (lambda: from_frames(body={**BALL, "raduis": 1.0}), "raduis", "radius"),
    (lambda: hlcs.compare(from_frames(model={"effects": [{"name": "magnos", "lift": 0.5}]})), "'magnos'", "magnus"),
    (lambda: hlcs.compare(from_frames()).to_dataframe("wher"), "'wher'", "where"),
    (lambda: hlcs.compare(from_frames()).to_dataframe("observation"), "'observation'", "observations"),
    (lambda: hlcs.diagnose(from_frames(), candidates="quadratic_darg"), "'quadratic_darg'", "quadratic_drag"),
    (lambda: hlcs.diagnose(from_frames(), candidates=["lineardrag"]), "'lineardrag'", "linear_drag"),
]


@pytest.mark.parametrize(("call", "wrong", "meant"), WRONG, ids=[wrong for _, wrong, _ in WRONG])
def test_a_wrong_word_is_refused_with_the_one_that_was_meant(call, wrong, meant):
    with pytest.raises(hlcs.InputError) as refused:
        call()
    message = str(refused.value)
    assert wrong in message and "\n" not in message
    assert f"did you mean '{meant}'?" in message or message.partition("nearest")[2].split("'")[1] == meant


def test_a_wrong_name_of_the_package_is_found_by_python_itself():
    """Python names the nearest attribute of the object that an AttributeError carries."""
    with pytest.raises(AttributeError) as refused:
        hlcs.PlacmentTest  # noqa: B018
    assert refused.value.name == "PlacmentTest" and refused.value.obj is hlcs and "PlacementTest" in dir(hlcs)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: hlcs.reproduce("foo"), "table = 'foo'; it must be one of table1, table2, table3, figures, workability"),
        (lambda: preset("foo"), "preset 'foo': unknown; known are paper"),
        (lambda: from_frames(body={**BALL, "shape": "ball"}), "'ball' is not one of"),
        (
            lambda: hlcs.import_measurements("a.csv", "csv", "out", constant={"xyz": 1.0}),
            "no input of a table; known are height_m",
        ),
    ],
)
def test_of_a_word_that_is_like_none_it_is_listed_what_there_is(call, told):
    with pytest.raises(hlcs.InputError) as refused:
        call()
    assert told in str(refused.value) and "nearest" not in str(refused.value) and "did you mean" not in str(refused.value)


@pytest.mark.parametrize("path", [3, None, b"name"])
def test_what_can_be_no_path_is_refused_in_words(path):
    """Whatever is to be read or written."""
    calls = (mb.mesh_file, mb.World().save, mb.World.load, from_frames().save)
    for call in calls:
        with pytest.raises(hlcs.InputError, match="is no path; give its name as text"):
            call(path)


@pytest.mark.parametrize(
    ("words", "told"), [("hilly", ""), ("slop:0.04", "; did you mean 'slope'?"), ("Falt", "; did you mean 'flat'?")]
)
def test_where_other_words_may_be_right_only_one_that_is_alike_is_offered(words, told):
    """A bottom may be any survey: nothing is guessed of a word that is like none."""
    with pytest.raises(hlcs.InputError) as refused:
        hlcs.PlacementTest(bottom=words)
    assert str(refused.value).endswith(f"a survey such as bed.csv{told}")


def test_a_placement_test_shows_what_it_is_with_units():
    shown = repr(hlcs.PlacementTest(grid="1.5,1.3", margin=0.008, settle_time=5.0))
    assert "spacing_x=1.5 Dn" in shown and "side=1 m" in shown and "margin=0.008 Dn" in shown and "settle_time=5 s" in shown
    assert (
        "vibration" not in shown and "<td>margin</td><td>0.008</td><td>Dn</td>" in hlcs.PlacementTest(margin=0.008)._repr_html_()
    )


FITTING = {"body": BALL, "noise": {"position": 0.001}}
NO_ARGUMENT = [  # what is called; the argument, what was given of it, and the remedy, as the message names them
    (lambda: hlcs.Experiment.from_frames([], **FITTING), r"frames: got \[\]; give a pandas frame"),
    (lambda: hlcs.Experiment.from_frames(3, **FITTING), "frames: got 3; give a pandas frame"),
    (lambda: hlcs.Experiment.from_frames(None), "frames: got None; give a pandas frame"),
    (lambda: hlcs.Experiment.from_frames(np.zeros((3, 2))), r"frames: got ndarray of shape \(3, 2\); give a pandas frame"),
    (lambda: hlcs.Experiment.from_frames("drop.csv"), "frames: got 'drop.csv', a text; pandas.read_csv reads"),
    (lambda: hlcs.Experiment.from_frames({"a": DROP, "b": DROP}), "frames: a dictionary of frames; give a list"),
    (lambda: hlcs.Experiment.from_frames([DROP, 3]), "frame 2: int has no columns by name; give a pandas frame"),
    (lambda: from_frames(trials=3), "trials: got 3; give a list of one dictionary for each frame"),
    (lambda: from_frames(trials=["a"]), "trials: got 'a'; give a list of one dictionary for each frame"),
    (lambda: from_frames(trials=[{}, {}]), "2 trials for 1 frames; give one dictionary for each frame"),
    (lambda: from_frames(trial=[{}]), r"trial: frames have none; give trials=\[\{\.\.\}"),
    (lambda: from_frames(kind=["trajectory"]), "kind: must be text"),
    (lambda: from_frames(measurement=3), "measurement: got 3; give a dictionary"),
    (lambda: from_frames(measurement={"noise": {"position": 0.1}}), r"measurement: noise = .* beside noise=..; give one of them"),
    (lambda: from_frames(measurement={"file": "a.csv"}), "measurement: file = 'a.csv' beside the frame; give one of them"),
    (lambda: from_frames(body=3), "body: must be a table, got 3"),
    (lambda: hlcs.compare(3), "experiment: got 3; give the path of an experiment file"),
    (lambda: hlcs.diagnose([DROP]), "experiment: got list; give the path of an experiment file"),
    (lambda: hlcs.compare(from_frames(), effects=3), r"effects: got 3; give a list, such as \[minibullet.QuadraticDrag"),
    (lambda: hlcs.compare(from_frames(), effects="drag"), "effects: got 'drag'; give a list"),
    (lambda: hlcs.diagnose(from_frames(), candidates=3), "candidates: got 3; give a name or a list of names"),
    (lambda: hlcs.diagnose(from_frames(), candidates=[]), r"candidates: got \[\]; give a name or a list of names"),
    (lambda: from_frames(diagnose={"candidates": []}), "diagnose.candidates: names no effect; name some, or leave it out"),
]


@pytest.mark.parametrize(("call", "told"), NO_ARGUMENT, ids=[told[:30] for _, told in NO_ARGUMENT])
def test_what_is_no_such_argument_is_refused_with_what_was_given_and_the_remedy(call, told):
    with pytest.raises(hlcs.InputError, match=f"^(frames: )?{told}") as refused:
        call()
    assert "\n" not in str(refused.value)


def test_the_noise_of_a_frame_may_stand_in_the_section_where_a_file_has_it():
    """It was lost once beside the argument that was left out."""
    said = hlcs.Experiment.from_frames([DROP], body=BALL, measurement={"noise": {"position": 0.002}})
    assert said.file.noise == from_frames(noise={"position": 0.002}).file.noise != from_frames().file.noise

"""A user's file of effects: loaded and checked, or refused by file and line."""

import sys

import numpy as np
import pytest

import minibullet as mb
from hlcs.simulation.free_flight import fly
from minibullet import effects
from minibullet.bodies import Bodies
from minibullet.effects import catalogue
from minibullet.effects.samples import sample_bodies
from minibullet.errors import InputError

HEAD = """from dataclasses import dataclass
import minibullet.effects as mb

"""
GOOD = (
    HEAD
    + """@dataclass(frozen=True)
class MyDrag(mb.Effect):
    rate: float = mb.parameter(0.0, unit="1/s", low=0, high=5, null=0.0)

    def forces(self, bodies, time):
        wrench = -self.rate * bodies.mass[:, None] * bodies.twist
        wrench[:, 3:] = 0.0
        return wrench


class _Hidden(mb.Effect):
    pass
"""
)


def test_a_new_effect_is_one_class_in_one_file(tmp_path, monkeypatch):
    """Found in its package without a list; classes without numbers and those made elsewhere are none."""
    package = tmp_path / "a_room_of_effects"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "wind.py").write_text(GOOD + "\n\nclass Base(mb.Drag):\n    pass\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert list(catalogue.classes_in("a_room_of_effects", effects.Effect)) == ["my_drag"]


def test_every_shipped_effect_is_offered_by_its_name():
    assert {kind.__name__ for kind in effects.library().values()} <= set(effects.__all__) <= set(dir(mb))
    assert {"Drag", "DragModifier", "FluidForce"} <= set(dir(mb))  # made to be subclassed by a drag of the user's own


def written(folder, text, name="my_effects.py"):
    path = folder / name
    path.write_text(text)
    return path


def test_good_file_gives_its_classes_by_name(tmp_path):
    found = effects.load_effects(written(tmp_path, GOOD))
    assert list(found) == ["my_drag"]
    assert found["my_drag"](rate=2.0).rate == 2.0


def test_two_files_of_one_name_do_not_mix(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    first = effects.load_effects(written(tmp_path / "a", GOOD))
    second = effects.load_effects(written(tmp_path / "b", GOOD.replace("MyDrag", "YourDrag")))
    assert (*first, *second) == ("my_drag", "your_drag")
    assert first["my_drag"].__module__ != second["your_drag"].__module__


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        (HEAD + "class MyDrag(mb.Effect)\n", 4, "expected ':'"),
        (HEAD + "import not_a_package_at_all\n", 4, "ModuleNotFoundError"),
        (GOOD.replace("bodies.mass[", "bodies.density["), 9, "AttributeError"),
        (GOOD.replace("-self.rate", "1.0 - self.rate"), 4, "the rule 'null'"),
        (GOOD.replace("MyDrag", "LinearDrag"), 4, "belongs to a shipped effect"),
        (
            GOOD.replace('mb.parameter(0.0, unit="1/s", low=0, high=5, null=0.0)', "None").replace("float = None", "float"),
            4,
            "give every field a default",
        ),
    ],
)
def test_bad_file_is_refused_by_line(tmp_path, text, line, message):
    path = written(tmp_path, text)
    with pytest.raises(InputError) as caught:
        effects.load_effects(path)
    assert str(caught.value).startswith(f"{path}:{line}: ") and message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_file_without_effects_or_missing_is_refused(tmp_path):
    with pytest.raises(InputError, match="defines no effect"):
        effects.load_effects(written(tmp_path, "x = 1\n"))
    with pytest.raises(InputError, match="No such file"):
        effects.load_effects(tmp_path / "nothing.py")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import sys\nsys.exit(0)\n", ":2: SystemExit"),
        ("raise BaseException('stop')\n", ":1: BaseException: stop"),
        ("def f(): f()\nf()\n", ":1: RecursionError"),
        ("x = " + "(" * 3000 + ")" * 3000 + "\n", ":1: "),
        (
            GOOD.replace("    def forces", "    def __post_init__(self):\n        raise OSError('no')\n    def forces"),
            "OSError: no",
        ),
        (GOOD.replace("wrench = -self.rate", "raise SystemExit(0); wrench = -self.rate"), ":9: SystemExit"),
        (HEAD + "Made = type('Made', (mb.Effect,), {'__module__': __name__})\n", "Made"),
    ],
)
def test_a_file_that_ends_the_program_or_breaks_in_any_other_way_is_refused_by_line(tmp_path, text, message):
    path = written(tmp_path, text)
    with pytest.raises(InputError) as caught:
        effects.load_effects(path)
    assert str(caught.value).startswith(f"{path}:") and message in str(caught.value) and "\n" not in str(caught.value)


def test_a_file_that_is_no_regular_file_is_refused_unread(tmp_path):
    (tmp_path / "loop.py").symlink_to(tmp_path / "loop.py")
    with open(tmp_path / "long.py", "wb") as file:
        file.truncate(2_000_000)
    for name, message in (("loop.py", "symbolic links"), (".", "folder"), ("a" * 300 + ".py", "too long"), ("long.py", "1 MB")):
        with pytest.raises(InputError, match=message):
            effects.load_effects(tmp_path / name)


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        ("raise KeyError('late')", ":13: KeyError"),
        ("raise SystemExit(0)", ":13: SystemExit"),
        ("return None", "MyDrag: answered shape ()"),
        ("return wrench[:, :3]", "MyDrag: answered shape (1, 3)"),
        ("return np.nan * wrench", "MyDrag: the answer for moving body 0 is not finite"),
    ],
)
def test_what_goes_wrong_in_the_middle_of_a_run_is_told_by_file_and_line(tmp_path, answer, message):
    """After the checks of the start; whoever asks: here the engine and the free flight of `hlcs`."""
    text = GOOD.replace("        return wrench", f"        if late:\n            {answer}\n        return wrench")
    path = written(tmp_path, "import numpy as np; late = False\n" + text)
    effect = effects.load_effects(path)["my_drag"](rate=0.1)
    sys.modules[type(effect).__module__].late = True
    world = mb.World(effects=[effect])
    world.add(mb.shapes.primitives.Sphere(0.1), density=1000.0, position=(0.0, 0.0, 9.0))
    bodies = Bodies(*(column[:1] for column in sample_bodies()))
    for run in (lambda: world.run(0.2), lambda: fly(bodies, (effect,), 0.2, 0.01)):
        with pytest.raises(InputError) as caught:
            run()
        assert f"{path}:" in str(caught.value) and message in str(caught.value)


def test_an_effect_is_not_blamed_for_a_flight_beyond_all_numbers(tmp_path):
    """What is infinite in the answer was so in the question: a search that tried it goes on."""
    effect = effects.load_effects(written(tmp_path, GOOD))["my_drag"](rate=0.1)
    bodies = sample_bodies()
    answer = effect.forces(bodies._replace(twist=np.full_like(bodies.twist, np.inf)), 0.0)
    assert not np.isfinite(answer[:, :3]).any()

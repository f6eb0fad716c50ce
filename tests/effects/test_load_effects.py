"""A user's file of effects: loaded and checked, or refused by file and line."""

import pytest

from minibullet import effects
from minibullet.errors import InputError

HEAD = """from dataclasses import dataclass
import minibullet.effects as mb

"""
GOOD = HEAD + """@dataclass(frozen=True)
class MyDrag(mb.Effect):
    rate: float = mb.parameter(0.0, unit="1/s", low=0, high=5, null=0.0)

    def forces(self, bodies, time):
        wrench = -self.rate * bodies.mass[:, None] * bodies.twist
        wrench[:, 3:] = 0.0
        return wrench


class _Hidden(mb.Effect):
    pass
"""


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


@pytest.mark.parametrize(("text", "line", "message"), [
    (HEAD + "class MyDrag(mb.Effect)\n", 4, "expected ':'"),
    (HEAD + "import not_a_package_at_all\n", 4, "ModuleNotFoundError"),
    (GOOD.replace("bodies.mass[", "bodies.density["), 9, "AttributeError"),
    (GOOD.replace("-self.rate", "1.0 - self.rate"), 4, "the rule 'null'"),
    (GOOD.replace("MyDrag", "LinearDrag"), 4, "belongs to a shipped effect"),
    (GOOD.replace('mb.parameter(0.0, unit="1/s", low=0, high=5, null=0.0)', "None").replace("float = None", "float"), 4,
     "give every field a default"),
])
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


@pytest.mark.parametrize(("text", "message"), [
    ("import sys\nsys.exit(0)\n", ":2: SystemExit"), ("raise BaseException('stop')\n", ":1: BaseException: stop"),
    ("def f(): f()\nf()\n", ":1: RecursionError"), ("x = " + "(" * 3000 + ")" * 3000 + "\n", ":1: "),
    (GOOD.replace("    def forces", "    def __post_init__(self):\n        raise OSError('no')\n    def forces"), "OSError: no"),
    (GOOD.replace("wrench = -self.rate", "raise SystemExit(0); wrench = -self.rate"), ":9: SystemExit"),
    (HEAD + "Made = type('Made', (mb.Effect,), {'__module__': __name__})\n", "Made"),
])
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

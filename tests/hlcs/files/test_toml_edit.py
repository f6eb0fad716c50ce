"""A value of a user's TOML file is set: it reads as it should, and nothing else has moved."""

import tomllib

import pytest

from hlcs.files.toml_edit import with_values

EFFECTS = [{"name": "old", "rate": 1.5}, {"name": "new", "coefficient": 0.25}]
REST = '# above\n[measurement]\nfile = "a.csv"  # data\n\n[[trial]]\nfile = "b # c.csv"\n'


@pytest.mark.parametrize(
    "model",
    [
        "[model]\neffects = []  # none\n",
        "[model]\n",
        "",
        "[model]\n# one\neffects = [\n  # two\n]  # three\ntime_step = 0.004 # four\n",
        '[model]\neffects = [{ name = "old", rate = 1.5 }]\nadded = ["old"]  # five\n',
        '[model]\neffects = [\n  { name = "old", rate = 1.5 }  # six\n]\n',
        '[model]\neffects = [\n  { name = "old", rate = 1.5 },  # seven\n]\n',
        '[model]\neffects = [\n  { name = "other # name" },  # eight\n  "plain",\n]\n',
    ],
)
@pytest.mark.parametrize("added", [["new"], None])
def test_a_value_is_set_and_every_comment_stays(model, added):
    text = model + REST
    new = with_values(text, "model", {"effects": EFFECTS, "added": added}, ("measurement", "trial"))
    meant = tomllib.loads(text)
    meant["model"] = {**meant.get("model", {}), "effects": EFFECTS, "added": added}
    if added is None:
        del meant["model"]["added"]
    assert tomllib.loads(new) == meant
    comments = [line[line.rindex("#") :] for line in text.splitlines() if "#" in line and not line.endswith('c.csv"')]
    assert [line[line.rindex("#") :] for line in new.splitlines() if "#" in line and not line.endswith('c.csv"')] == comments
    assert REST in new


def test_what_is_there_already_is_left_alone():
    text = "[model]\neffects = [ ]   # spaced\n"
    assert with_values(text, "model", {"effects": [], "added": None}) == text
    assert with_values(REST, "model", {"effects": None}) == REST

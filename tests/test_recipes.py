"""The recipes name places that exist, stay short, and two of them are followed to the end."""

import re
from pathlib import Path

import numpy as np
import pytest

import hlcs
import minibullet as mb
from hlcs.data.experiment_file import Layout
from hlcs.kinds import KINDS
from hlcs.kinds.protocol import Observation, misfit
from hlcs.rendering import Pictures
from hlcs.selection.verdict import Selection

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "recipes.md").read_text(encoding="utf-8")
RECIPES = {part.partition("\n")[0]: part.partition("\n")[2].strip() for part in PAGE.split("\n## ")[1:]}


def code(recipe):
    """The code block of a recipe."""
    return re.search(r"```python\n(.+?)```", RECIPES[recipe], re.DOTALL).group(1)


@pytest.mark.parametrize("recipe", RECIPES)
def test_a_recipe_is_at_most_fifteen_lines_and_names_places_that_exist(recipe):
    assert len(RECIPES[recipe].splitlines()) <= 15
    places = [ROOT / place for place in re.findall(r"`((?:hlcs|minibullet)/[\w/.]+)`", RECIPES[recipe])]
    assert places and all(place.exists() for place in places), places


def test_the_recipe_of_a_shape_makes_one_that_rests_on_its_base():
    """Volume of a prism: half a box; centre of mass a third of the height up; at rest it stands there."""
    scope = {}
    exec(code("A shape"), scope)  # a page of this repository, not a user's file
    shape = scope["wedge"](2.0, 1.0, 0.6)
    assert shape.volume == pytest.approx(0.6, rel=1e-12)
    world = mb.World([mb.Gravity(9.81)], mb.Settings(friction=0.6))
    world.add_plane()
    body = world.add(shape, density=1000.0, position=(0.0, 0.0, 0.3))
    world.settle(max_time=5.0)
    assert body.position[2] == pytest.approx(0.2, abs=1e-5)


def test_the_recipe_of_an_effect_makes_one_that_is_found(tmp_path):
    """Balls thrown up in a side wind of 1.5 m/s2: x = v t + a t^2 / 2, written down without the engine."""
    (tmp_path / "own.py").write_text(code("An effect"))
    mb.check_effect(mb.load_effects(tmp_path / "own.py")["side_wind"]())  # raises where it fails
    generator, trials = np.random.default_rng(5), ""
    for number in range(4):
        t = np.arange(0.0, 0.8, 0.02)
        speed = np.array([0.5 * number, 0.3, 4.0])
        place = t[:, None] * speed + 0.5 * t[:, None] ** 2 * np.array([1.5, 0.0, -9.81])
        rows = np.column_stack([t, place + 0.001 * generator.standard_normal(place.shape)])
        np.savetxt(tmp_path / f"throw_{number}.csv", rows, delimiter=",", header="t_s,x_m,y_m,z_m", comments="", fmt="%.6f")
        trials += f'[[trial]]\nfile = "throw_{number}.csv"\ngroup = "{number}"\n'
    text = 'kind = "trajectory"\n[body]\nshape = "sphere"\nradius = 0.03\nmass = 0.1\n[surroundings]\nfluid_density = 0.0\n'
    (tmp_path / "throws.toml").write_text(text + "[measurement]\nnoise = { position = 0.001 }\n" + trials)
    names = ["side_wind", "quadratic_drag", "length_scale", "clock_offset"]
    found = hlcs.diagnose(tmp_path / "throws.toml", candidates=names, effects_file=tmp_path / "own.py")
    assert found.verdict == "effect" and found.effects == ("side_wind",)
    push = found.parameters["side_wind"]["push"]
    half = (push["high"] - push["low"]) / 2  # 1.6 standard errors
    assert half < 0.02 and abs(push["value"] - 1.5) < 2.0 * half


class Weighings:
    """A kind of measurement that takes one column of masses: the model is one mass, what may be missing a zero offset."""

    kind, measure, unit, layout = "weighings", "rms", "kg", Layout(False, {})
    judgeable, advice, unjudged, notes = True, "", None, ()

    def __init__(self, file, options):
        self.title, self.mass = file.title, file.body.mass
        self.measured = np.loadtxt(file.data_file, skiprows=1)
        self.noise = {"source": "stated", "outcome": file.noise["outcome"]}

    def _judged(self, model):
        residual = self.measured - model
        chi2 = float(np.mean((residual / self.noise["outcome"]) ** 2))
        rows = {"measured": self.measured, "model": np.full(len(residual), model), "residual": residual}
        table = rows | {"sigmas": residual / self.noise["outcome"], "row": np.arange(len(residual))}
        return chi2 < 2.0, chi2, table | {"channel": np.zeros(len(residual), int)}

    def observe(self):
        adequate, chi2, table = self._judged(self.mass)
        error = misfit(table["residual"], self.unit, self.noise["outcome"])
        return Observation(adequate, chi2, 0.5, error, (), table, (), {"against": ("row",)})

    def names(self, candidates):
        return ("zero_offset",)

    def search(self, candidates):
        offset = float(np.mean(self.measured) - self.mass)
        before, after = self._judged(self.mass), self._judged(self.mass + offset)
        found = ("zero_offset",) if not before[0] else ()
        number = {"value": offset, "low": offset - 0.01, "high": offset + 0.01, "unit": "kg"}
        adequate = {"before": before[0], "after": after[0], "statistic": after[1], "p": 0.5}
        numbers = {"zero_offset": {"offset": number}} if found else {}
        error = {"measure": self.measure, "unit": self.unit, "fitted": None, "held_out": None}
        pictures = Pictures(before[2], after[2], (), "row", "row")
        return Selection(
            effects=found,
            parameters=numbers,
            ambiguous=(),
            error=error,
            steps=(),
            adequate=adequate,
            candidates=(),
            where=(),
            pictures=pictures,
            next_experiment=lambda verdict: None,
        )


def test_the_recipe_of_a_kind_needs_one_class_and_its_name(tmp_path, monkeypatch):
    """Ten weighings 0.3 kg too high: compared, diagnosed, printed, drawn and saved by code that has never heard of them."""
    monkeypatch.setitem(KINDS, "weighings", Weighings)
    masses = 5.3 + 0.005 * np.random.default_rng(3).standard_normal(10)
    np.savetxt(tmp_path / "scale.csv", masses, header="mass_kg", comments="")
    text = 'kind = "weighings"\n[body]\nshape = "sphere"\nradius = 0.1\nmass = 5.0\n'
    (tmp_path / "scale.toml").write_text(text + '[measurement]\nfile = "scale.csv"\nnoise = 0.01\n')
    comparison, diagnosis = hlcs.compare(tmp_path / "scale.toml"), hlcs.diagnose(tmp_path / "scale.toml")
    assert not comparison.adequate and comparison.error["bias"] == pytest.approx(-0.3, abs=0.01)
    assert diagnosis.verdict == "effect" and diagnosis.effects == ("zero_offset",) and "zero_offset" in str(diagnosis)
    comparison.save(tmp_path / "comparison")
    assert {path.name for path in (tmp_path / "comparison").iterdir()} >= {"comparison.png", "residuals.csv", "comparison.json"}
    diagnosis.plot()

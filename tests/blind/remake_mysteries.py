"""Make the data sets of hlcs/mystery again, bit for bit: `python -m tests.blind.remake_mysteries [--out hlcs/mystery/data]`.

Before them it writes what pybullet gave for layers, hlcs/mystery/layers_in_pybullet.csv: those causes of the deck's
generator/layer_answers.csv that `hlcs mystery make` can hide.

The recipes below say what is hidden; do not read on if you want to find out for yourself.
"""

import argparse
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hlcs.mystery import layers, making
from hlcs.mystery.seal import SEALED, opened, sealed

from . import tall_tank
from .generate import plain
from .generator import deck
from .generator.build import Deal, Redraw, trajectory
from .generator.case import write_case

OUT = Path(__file__).resolve().parents[2] / "hlcs" / "mystery" / "data"


class Recipe(NamedTuple):
    """One set: its name and title, what is hidden and how strongly, and what is said at the end."""

    name: str
    room: str
    title: str
    deal: Deal | Callable  # recordings; or a function of the title that gives the files of a table and what is in the answer
    story: str


def quarry_yard(title):
    """A plate of 0.05 Dn that was not taken off, twelve tests in each of four weeks: the scene of `hlcs mystery make`."""
    effect, amplitude, tests = "plate_bias", 0.05, 12
    request = {"strength": layers.strength(layers.OFFERS[effect], amplitude, tests)}
    files = making.layer_files(title, effect, amplitude, tests, np.random.default_rng([19_09_2021, 12]), request)
    return files, opened(files.pop(SEALED))


AIR, FLOOR, WATER = "air", "floor", "water and layers"  # the rooms; in each the sets go from easy to hard
RECIPES = (
    Recipe(
        "tower-drop",
        AIR,
        "Light balls let go from the landings of a stair tower, filmed from the side",
        Deal("flight", "single", ("quadratic_drag",), "drops", (45.0,), "white", 30),
        "Air resistance. The balls fall behind g t^2 / 2 the more, the faster they are.",
    ),
    Recipe(
        "long-hallway",
        FLOOR,
        "A plastic block launched along a waxed hallway, both ways and across",
        Deal("slide", "single", ("friction",), "launched", (12.0,), "white", 60),
        "The coefficient of friction in the model is not that of this floor. All headings stop short or long alike.",
    ),
    Recipe(
        "gym-floor",
        FLOOR,
        "A ball dropped in a gymnasium, followed over its first bounces",
        Deal("bounce", "single", ("restitution",), "drops", (8.0,), "white", 60),
        "The floor gives back another share of the speed than the catalogue says.",
    ),
    Recipe(
        "empty-gallery",
        AIR,
        "Balls thrown the length of an empty gallery",
        Deal("flight", "null", (), "throws", (), "ar6", 60),
        "Nothing. The model is complete at the precision of this camera, and saying so is the right answer.",
    ),
    Recipe(
        "marble-run",
        FLOOR,
        "A ball let go on gently inclined boards in four directions",
        Deal("roll", "single", ("rolling_friction",), "boards", (5.0,), "ar6", 60),
        "The ball sinks a hair into the board and pays for it: a rolling resistance, the same in all four directions.",
    ),
    Recipe(
        "harbour-tank",
        WATER,
        "Plastic beads pushed into a tank beside the harbour",
        Deal("sinking", "single", ("uniform_flow",), "pushed", (3.0,), "white", 60),
        "The water was not at rest. The drag in the model vanishes at the speed of the current, not at rest.",
    ),
    Recipe(
        "park-bench",
        AIR,
        "Iron balls put across a park, filmed from a bench with a borrowed camera",
        Deal("flight", "degenerate", ("time_scale",), "throws", (4.0,), "white", 30),
        "The clock of the camera runs wrong. In such a flight nobody can tell that from a wrong ruler: the right verdict is a "
        "set, and the next experiment films a clock or a ruler.",
    ),
    Recipe(
        "workshop-slab",
        FLOOR,
        "A slab held on its edge in a workshop and let go",
        Deal("topple", "single", ("centre_of_mass_offset",), "falls", (3.0,), "white", 60),
        "The slab is denser on one side: its centre of mass is not in the middle.",
    ),
    Recipe(
        "practice-night",
        AIR,
        "Footballs kicked with spin at night, every second one with the opposite spin",
        Deal("flight", "double", ("magnus", "spin_decay"), "spinning", (3.0, 8.0), "white", 60),
        "Two effects: the spin bends the flight (the side changes with the spin), and the spin itself dies away in the air.",
    ),
    Recipe(
        "attic-boards",
        FLOOR,
        "A small block of oak let go on a tilted attic board, timed by a trigger",
        Deal("slide", "double", ("friction", "clock_offset"), "incline", (3.0, 2.0), "ar6", 60),
        "Two effects: another friction than assumed, and a trigger that fires before the block is free.",
    ),
    Recipe(
        "north-window",
        AIR,
        "Balls thrown past an open window, filmed from a tripod on the floorboards",
        Deal("flight", "mixed", ("quadratic_drag", "camera_shake"), "throws", (40.0, 1.5), "white", 60),
        "Two effects: air resistance, which the library knows, and a tripod that shakes, which it does not. Drag must be "
        "found, and the verdict must still be that something is unexplained.",
    ),
    Recipe(
        "tall-tank",
        WATER,
        "Glass marbles timed by hand as they sink in a tall tank",
        tall_tank.table,
        "The depths were read along a glass that leans by 15 degrees, so every one is 3.5 % too long. A slow watch, a heavier or "
        "a smaller marble, or a drag that is not as stated, would give the same times: the right verdict is a set, and a "
        "calliper, another ruler and a second watch decide.",
    ),
    Recipe(
        "quarry-yard",
        WATER,
        "Cubipods laid in three layers on the floor of a quarry, read with a staff on a plate",
        quarry_yard,
        "The staff stood on a plate that is 0.05 Dn thick, and nobody took that off. It cancels where one layer is taken from "
        "the next, so the first layer alone reads too thick. Units of the first layer that stand on a tip would read the same: "
        "the right verdict is a set, and photographs of the first layer, or a calliper on the plate, decide.",
    ),
)
PYBULLET = Path(__file__).resolve().parent / "generator" / "layer_answers.csv"


def make(recipe, number):
    """{file name: text} of one set, answer included."""
    if callable(recipe.deal):
        files, answer = recipe.deal(recipe.title)
        return files | {SEALED: hidden(recipe, answer)}
    for attempt in range(60):
        rng = np.random.default_rng([19_09_2021, number, attempt])
        try:
            files, answer = trajectory(recipe.deal, deck.ROOMS[recipe.deal.family], rng)
        except Redraw:
            continue
        if "fluid_density = 0.0" in files["experiment.toml"]:  # no park and no hallway is a vacuum
            continue
        if (
            "mass = 0.0027" in files["experiment.toml"]
        ):  # air brakes a table tennis ball more than the engine's usual step resolves
            continue
        drag = answer["parameters"].get("quadratic_drag", {}).get("drag_coefficient", 0.45)
        if not 0.3 <= drag <= 0.6:  # a ball that exists
            continue
        files["experiment.toml"] = re.sub(r"^title = .*$", f'title = "{recipe.title}"', files["experiment.toml"], flags=re.M)
        header, *rows = files["rest.csv"].splitlines()
        files["rest.csv"] = "\n".join([header, *rows[:300]]) + "\n"
        if sum(map(len, files.values())) > 60_000:
            continue
        return files | {SEALED: hidden(recipe, answer)}
    raise RuntimeError(f"{recipe.name} could not be made")


def hidden(recipe, answer):
    """The text of the sealed answer."""
    wanted = ("effects", "parameters", "hidden_laws", "strengths", "tied", "possible", "outside", "noise")
    return sealed({**plain({key: answer[key] for key in wanted}), "text": told(recipe, answer)})


def told(recipe, answer):
    """The text that `reveal` prints."""
    lines = [f"{recipe.name}: {recipe.title}.", "", recipe.story, ""]
    for name in answer["effects"]:
        strength = answer["strengths"][name]
        law = answer["parameters"].get(name) or {}
        value = ", ".join(f"{key} = {number:.4g}" for key, number in law.items())
        lines.append(f"  {name}: strength {strength:.1f} sigma" + (f"; as the library writes it: {value}" if value else ""))
    if answer["tied"]:
        lines.append(f"  These data cannot tell it from: {', '.join(sorted(answer['tied']))}.")
    noise = answer["noise"]
    if "tests" in noise:
        lines.append(f"  {making.spread_of_tests(noise['tests'])}")
    elif "time" in noise:
        lines.append(f"  Noise of a timing by hand: {1000 * noise['time']:.2g} ms.")
    else:
        lines.append(f"  Noise of the tracker: {1000 * noise['position']:.2g} mm.")
    return "\n".join(lines) + "\n"


def from_pybullet():
    """Text of hlcs/mystery/layers_in_pybullet.csv: of the deck's file the heading and the causes that a mystery can hide."""
    heading, names, *rows = PYBULLET.read_text(encoding="utf-8").splitlines(keepends=True)
    return "".join([heading, names, *(row for row in rows if row.split(",")[0] in ("none", *layers.OFFERS))])


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", default=OUT)
    out = Path(parser.parse_args(arguments).out)
    layers.PYBULLET.write_text(from_pybullet(), encoding="utf-8")
    for number, recipe in enumerate(RECIPES):
        for old in (out / recipe.name).glob("*"):  # another number of recordings must leave no strays
            old.unlink()
        write_case(out / recipe.name, make(recipe, number))
    (out / "order.json").write_text(json.dumps(by_room(), indent=1) + "\n", encoding="utf-8")


def by_room():
    """{room: names of its sets}, in the order in which they are to be listed."""
    return {room: [recipe.name for recipe in RECIPES if recipe.room == room] for room in (AIR, FLOOR, WATER)}


if __name__ == "__main__":
    main()

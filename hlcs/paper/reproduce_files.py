"""Run one table of the paper, and write its JSON, its text, and its pictures."""

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from hlcs.files import folders
from hlcs.kinds.experiment import Experiment
from hlcs.paper import blender, drawings, figure_list, index_page, ladder, reproduce, slope, workability
from hlcs.paper.reproduce_text import text_of, variants_of
from hlcs.placement import figures, playback
from hlcs.placement.comparison import sample_of
from hlcs.placement.grids import RPG
from hlcs.placement.number_text import percent
from hlcs.placement.printed_tables import laboratory, paper_numerical
from hlcs.placement.statistics import Sample
from minibullet.report import drawing

PICTURES = {  # file of the picture of a table
    "table1": "sensitivity.png",
    "table2": "table2.png",
    "table3": "table3.png",
    "figures": "layers.png",
    "workability": "workability.png",
}


def run(name, plan, folder=None, progress=None, out=None):
    """(document, text) of table `name`; its files go into `folder` where one is given, whose name will be `out` in the end."""
    if name == "ladder":
        return _ladder(plan, folder, progress, out or folder)
    if name == "blender":
        return _blender(plan, folder, progress)
    make = {"slope": slope.slope, "set_back": workability.set_back, "workability": workability.workability}
    document = (make.get(name) or getattr(reproduce, name))(plan, progress)
    text = text_of(document)
    if folder:
        if name == "figures":
            document["drawings"] = _draw(plan, folder, progress)
        folders.write_json(folder / f"{name}.json", document)
        folders.write_text(folder / f"{name}.txt", text + "\n")
        if name in PICTURES:
            folders.write_bytes(folder / PICTURES[name], figures.png_bytes(axes_of(document)[0].figure))
    return document, text


def write_index(documents, texts, folder, seconds=None):
    """index.html: all tables and figures beside the paper's numbers; seconds: what they took."""
    folders.write_text(folder / "index.html", index_page.page(documents, texts, seconds))


def _draw(plan, folder, progress):
    """Write the paper's figures from our runs, and a layer that falls, into the folder; returns their entries as dictionaries."""
    found = reproduce.drawn_results(plan, progress)
    first = plan.test(grid=RPG, seed=plan.seed)
    low = replace(first, layers=min(2, first.rows, first.columns))
    fall = playback.record_fall(low, low.layers)
    unit, dn, blind = first.unit, first.unit.nominal_diameter, found["blind"]
    drawing.draw_scene(figures.scene_of(found["TPG"]), folder / "structure.png")
    pictures = {
        "02": (drawings.unit, unit),
        "03": (drawings.grids, dn),
        "04": (drawings.measuring, found["TPG"]),
        "06": (drawings.before_and_after, fall),
        "07": (drawings.front_and_side, found["RPG"]),
        "08": (drawings.plates, found["TPG"]),
        "11": (drawings.side_and_top, found["slope"]),
        "13": (drawings.blind_grids, dn),
        "14": (drawings.blind, blind),
    }
    for number, (draw, content) in pictures.items():
        folders.write_bytes(folder / f"figure_{number}.png", figures.png_bytes(draw(content), 120, tight=True))
    folders.write_bytes(folder / "falling_layer.gif", drawings.falling(fall))
    folders.write_text(folder / "falling_layer.html", drawings.falling_page(fall))
    marked = int(drawings.marked(blind).sum())
    entries = figure_list.drawn_entries(unit, found["RPG"], found["TPG"], found["slope"], blind, marked)
    return [entry._asdict() for entry in entries]


def _ladder(plan, folder, progress, out):
    """The ladder, and into the folder besides: the experiment files, and the report of the diagnosis."""
    with nullcontext(folder) if folder else TemporaryDirectory() as place:
        document, diagnosis = ladder.ladder(plan, Path(place), progress is not None)
    if folder:
        mended = diagnosis.apply(diagnosis.experiment)
        diagnosis = replace(diagnosis, mended=Experiment(replace(mended.file, path=Path(out) / "model.toml")))
    else:  # its files are gone
        diagnosis = replace(diagnosis, experiment=None)
    text = f"{ladder.ladder_text(document)}\n\n{diagnosis.summary()}"
    if folder:
        diagnosis.save(folder)
        folders.write_json(folder / "ladder.json", document)
        folders.write_text(folder / "ladder.txt", text + "\n")
    return document, text


def _blender(plan, folder, progress):
    """The comparison with Blender's runs and, with 20 seeds, with the laboratory."""
    document = blender.blender(plan, progress is not None)
    text = blender.blender_text(document)
    if folder:
        folders.write_json(folder / "blender.json", document)
        folders.write_text(folder / "blender.txt", text + "\n")
    return document, text


def axes_of(document, ax=None):
    """The picture of a document of one of PICTURES; ax: as many Axes as it has panels, None = of a new figure. Returns them."""
    table = document["table"]
    if table == "table1":
        return figures.tornado_axes(document["rows"], document["parameters"], document["base"], ax)
    if table == "workability":
        return figures.workability_axes(document["cases"], ax)
    variants = [(f"model, {words}", grids) for words, grids in settings_of(document).items()]
    return figures.grid_axes(_panels("table2" if table == "figures" else table, variants), ax)


def settings_of(document):
    """{setting in words: {grid: what its tests gave}} of table2, table3 or figures, the plan's own first."""
    if document["table"] != "figures":
        return variants_of(document)
    names = {"pieces": "seven pieces (true unit)", "hull": "convex hull"}
    return {names[shape]: grids for shape, grids in document["shapes"].items()}


def _panels(table, variants):
    """{title: samples}, a panel a grid: laboratory, the paper's numerical model, and ours."""
    panels = {}
    for grid in variants[0][1]:
        layers = len(variants[0][1][grid]["layers"])
        samples = [
            ("laboratory", _cut(laboratory(table, grid=grid), layers)),
            ("paper's numerical model", _cut(paper_numerical(table, grid=grid), layers)),
        ]
        samples += [
            (f"{name}: {percent(grids[grid]['mean_relative_error'])} %", _sample(grids[grid])) for name, grids in variants
        ]
        panels[f"{grid}: layer coefficients, and mean error to the laboratory"] = samples
    return panels


def _cut(table, layers):
    return Sample(*(part[:layers] for part in sample_of(table)[1]))


def _sample(found):
    """The Sample of a summary."""
    return Sample(*(np.array([row[key] for row in found["layers"]], dtype=float) for key in ("mean", "cv", "tests")))

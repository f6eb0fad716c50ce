"""Run one table of the paper, and write its JSON, its text, and its pictures."""

from contextlib import nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from hlcs.files import folders
from hlcs.paper import ladder, reproduce, slope, workability
from hlcs.paper.reproduce_text import text_of, variants_of
from hlcs.placement import figures
from hlcs.placement.comparison import sample_of
from hlcs.placement.number_text import percent
from hlcs.placement.printed_tables import laboratory, paper_numerical
from hlcs.placement.statistics import Sample
from minibullet.report import drawing


def run(name, plan, folder=None, progress=None):
    """(document, text) of table `name`; its files go into `folder` where one is given."""
    if name == "ladder":
        return _ladder(plan, folder, progress)
    make = {"slope": slope.slope, "set_back": workability.set_back, "workability": workability.workability}
    document, first = (make.get(name) or getattr(reproduce, name))(plan, progress), None
    if name == "figures":
        document, first = document
    text = text_of(document)
    if folder:
        folders.write_json(folder / f"{name}.json", document)
        folders.write_text(folder / f"{name}.txt", text + "\n")
        for picture, figure in _figures(document).items():
            folders.write_bytes(folder / picture, figures.png_bytes(figure))
        if first is not None:
            drawing.draw_scene(figures.scene_of(first), folder / "structure.png")
    return document, text


def _ladder(plan, folder, progress):
    """The ladder, and into the folder besides: the experiment files, and the report of the diagnosis."""
    with nullcontext(folder) if folder else TemporaryDirectory() as place:
        document, diagnosis = ladder.ladder(plan, Path(place), progress is not None)
    text = f"{ladder.ladder_text(document)}\n\n{diagnosis.summary()}"
    if folder:
        diagnosis.save(folder)
        folders.write_json(folder / "ladder.json", document)
        folders.write_text(folder / "ladder.txt", text + "\n")
    return document, text


def _figures(document):
    """{file name: Figure} of a document."""
    table = document["table"]
    if table == "table1":
        return {"sensitivity.png": figures.tornado_figure(document["rows"], document["parameters"], document["base"])}
    if table == "workability":
        return {"workability.png": figures.workability_figure(document["cases"])}
    if table in ("table2", "table3"):
        variants = [(f"model, {words}", grids) for words, grids in variants_of(document).items()]
        return {f"{table}.png": _panels(table, variants)}
    if table == "figures":
        names = {"pieces": "model, seven pieces (true unit)", "hull": "model, convex hull"}
        return {"layers.png": _panels("table2", [(names[shape], grids) for shape, grids in document["shapes"].items()])}
    return {}


def _panels(table, variants):
    """One panel a grid: laboratory, the paper's numerical model, and ours."""
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
    return figures.grid_figure(panels)


def _cut(table, layers):
    return Sample(*(part[:layers] for part in sample_of(table)[1]))


def _sample(found):
    """The Sample of a summary."""
    return Sample(*(np.array([row[key] for row in found["layers"]], dtype=float) for key in ("mean", "cv", "tests")))

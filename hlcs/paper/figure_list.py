"""Every figure of the paper accounted for: what it shows, the file that shows ours, and numbers of both beside each other."""

from typing import NamedTuple

import numpy as np

from hlcs.placement import layer_equations
from hlcs.placement.grids import RPG, TPG
from hlcs.placement.number_text import or_dash, percent
from hlcs.placement.printed_tables import laboratory, paper_numerical
from hlcs.placement.statistics import mean_relative_error


class Entry(NamedTuple):
    """One figure of the paper."""

    figure: str  # "Fig. 2"
    shows: str
    file: str  # in the folder of `hlcs reproduce all`; empty where we have none
    ours: str
    paper: str


# figures whose content no run can make, and why
NOT_REDRAWN = (
    Entry("Fig. 1", "cross-sections of a conventional and a homogeneous structure", "", "not redrawn: a sketch", "sketch"),
    Entry("Fig. 5", "the laboratory's frame, laser and plates", "", "not redrawn: photographs", "photographs"),
    Entry("Fig. 10", "the structure in the wave flume", "", "not redrawn: photographs", "photographs"),
)


def drawn_entries(unit, rectangular, triangular, slope, blind, marked):
    """Entries of the figures that `hlcs reproduce figures` draws; rectangular, triangular, slope, blind: PlacementResults;
    marked: units of the blind one that are lost or misplaced."""
    lab, model = laboratory("table2", grid="RPG"), paper_numerical("table2", grid="RPG")
    layers = len(rectangular.poses)
    height = or_dash(rectangular.height_over_dn, ".3f")
    heights = [or_dash(layer_equations.structure_height(table.mean[:layers]), ".3f") for table in (lab, model)]
    last = sum(np.isfinite(slope.readings[-1]))
    count, units = marked, sum(len(poses) for poses in blind.poses)
    spacings = f"a = {TPG.spacing_x:g}, b = {TPG.spacing_y:g} Dn"
    return [
        Entry("Fig. 2", "the unit", "figure_02.png", _unit_words(unit), "Dn = 1.07 m for L = 1 m, 1.298 Dn high at rest"),
        Entry(
            "Fig. 3", "both grids and their hollows", "figure_03.png",
            f"packing density RPG {RPG.packing_density:.3f}, TPG {TPG.packing_density:.3f}", "0.55 and 0.50",
        ),
        Entry(
            "Fig. 4", "how a layer is measured (Eq. 3)", "figure_04.png", f"TPG, k = {_k(triangular.layer_coefficients)}",
            f"laboratory {_k(laboratory('table2', grid='TPG').mean[: len(triangular.poses)])}",
        ),
        Entry(
            "Fig. 6", "the second layer on RPG before and after", "figure_06.png",
            f"k2 = {_k(rectangular.layer_coefficients[1:2]) or '-'}",
            f"laboratory {lab.mean[1]:.3f}, model {model.mean[1]:.3f}",
        ),
        Entry(
            "Fig. 7", "RPG from the front and the side", "figure_07.png", f"{layers} layers are {height} Dn high",
            f"laboratory {heights[0]}, model {heights[1]} Dn",
        ),
        Entry(
            "Fig. 8", "plates on the third and the fourth layer", "figure_08.png",
            f"{len(triangular.readings[0])} plates a layer", "at least six a layer",
        ),
        Entry(
            "Fig. 11", "the slope from the side and from above", "figure_11.png",
            f"{last} plates carried by layer {len(slope.poses)}, k = {_k(slope.layer_coefficients)}",
            f"three plates, model {_k(paper_numerical('table3', grid='TPG').mean[: len(slope.poses)])}",
        ),
        Entry("Fig. 13", "grids of three layers, blind reference", "figure_13.png", spacings, "a = 1.58, b = 1.27 Dn"),
        Entry(
            "Fig. 14", "blind reference on the slope", "figure_14.png", f"{count} of {units} units lost or misplaced, marked",
            "some misplaced, some fallen out; no numbers",
        ),
        Entry("Videos", "a layer that falls", "falling_layer.gif", "also falling_layer.html, with a slider", "two videos"),
    ]  # fmt: skip


def plotted_entries(documents):
    """Entries of Figs. 9 and 12, from the documents of Tables 2 and 3 where they are there."""
    for figure, table, shows in (("Fig. 9", "table2", "k against the layer, flat"), ("Fig. 12", "table3", "the same, slope")):
        if table in documents:
            grids = documents[table]["grids"]
            ours = ", ".join(f"{grid} {percent(found['mean_relative_error'])} %" for grid, found in grids.items())
            theirs = ", ".join(f"{grid} {_printed_error(table, grid, len(found['layers']))} %" for grid, found in grids.items())
            yield Entry(figure, shows, f"{table}.png", f"eps_R {ours}", f"eps_R {theirs}, from its printed means")


def _printed_error(table, grid, layers):
    """The paper's own eps_R of the first layers, in percent, from its printed means."""
    return percent(mean_relative_error(*(study(table, grid=grid).mean[:layers] for study in (laboratory, paper_numerical))))


def in_order(entries):
    """Entries by the number of their figure, what has none at the end."""
    return sorted(entries, key=lambda entry: int(entry.figure.split()[1]) if entry.figure.startswith("Fig") else 99)


def _unit_words(unit):
    diameter = unit.nominal_diameter / unit.side
    return f"Dn = {diameter:.3f} m for L = 1 m, {unit.first_layer_coefficient:.3f} Dn high at rest (reconstructed)"


def _k(coefficients):
    return " ".join(or_dash(k, ".3f") for k in coefficients)

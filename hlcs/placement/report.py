"""How a PlacementResult is shown and saved: printed, in a notebook, drawn, a folder of files with a page that opens offline."""

import base64
import html as markup
from pathlib import Path

import numpy as np

from hlcs.files import folders
from hlcs.placement import figures, top_view
from hlcs.placement.comparison import compare_layers, laboratory_for, sample_of
from hlcs.placement.number_text import or_dash, percent
from hlcs.placement.printed_tables import paper_numerical
from hlcs.placement.result_files import load_placement, write_numbers
from minibullet.errors import how_many
from minibullet.report import drawing

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 62em; margin: 2em auto; padding: 0 1em }
table { border-collapse: collapse; margin: 1em 0 } th, td { padding: .2em .9em; text-align: right; border-bottom: 1px solid #ddd }
th { font-weight: 600 } td:first-child, th:first-child { text-align: left }
iframe { width: 100%; height: 32em; border: 1px solid #ddd } img { max-width: 100%; height: auto }
.scroll { overflow-x: auto } .note { color: #666 } details { margin: 1em 0 }
"""


def line(result):
    """The result in a line: grid, units, height."""
    layers, units, dn = len(result.poses), sum(len(poses) for poses in result.poses), result.test.unit.nominal_diameter
    return (
        f"{result.test.grid.name} grid, {how_many(layers, 'layer')} of {how_many(units, 'unit')} of Dn {dn:.4g} m; height "
        f"{or_dash(result.height_over_dn, '.3f')} Dn = {or_dash(result.height_over_dn * dn, '.3f')} m, {result.lost.sum()} lost"
    )


def text(result):
    """A few lines of text: the layers, the height, what was lost or did not settle."""
    data = result.to_dict()
    lines = [
        f"{data['grid']} grid, {how_many(len(result.poses), 'layer')}, {how_many(sum(map(len, result.poses)), 'unit')}, shape "
        f"{data['shape']}, contact friction {result.test.friction:g}, seed {data['seed']}",
        *unit_lines(result.test),
        "layer       k   plates  left out      CV  units  lost  unsettled",
    ]
    lines += [
        f"{r['layer']:5d}  {or_dash(r['k'], '.3f'):>6}  {r['readings']:6d}  {r['unsupported_readings']:8d}  "
        f"{or_dash(r['cv'], '.4f'):>6}  {r['units']:5d}  {r['lost']:4d}  {r['unsettled']:9d}"
        for r in data["layers"]
    ]
    lines += [
        f"height {or_dash(data['height_over_dn'], '.3f')} Dn, deepest overlap {data['max_penetration_over_dn']:.1e} Dn, "
        f"{result.wall_seconds:.1f} s, {1e3 * result.wall_seconds / sum(len(p) for p in result.poses):.0f} ms a unit",
        f"porosity {or_dash(data['achieved_porosity'], '.3f')} achieved, {or_dash(data['porosity'], '.3f')} nominal; packing "
        f"density {or_dash(data['achieved_packing_density'], '.3f')} achieved, {data['packing_density']:.3f} nominal",
        in_metres(data),
        *notes(result),
    ]
    return "\n".join(lines)


def unit_lines(test):
    """What a unit from a mesh file was found to be, lines of text; none for a built-in unit, whose measures are known."""
    return [] if isinstance(test.armour, str) else test.unit.description(test.density).split("\n")


def in_metres(data):
    """The result, a dictionary as the JSON has it, in metres for these units: one sentence."""
    level, scatter = or_dash(data["crest_level_m"], ".3f"), or_dash(data["crest_level_sd_m"], ".3f")
    return (
        f"units of Dn {data['nominal_diameter_m']:.4g} m: crest {level} m above datum (single plates scatter by {scatter} m); "
        f"{data['concrete_m3']:.4g} m3 of concrete in all, per metre of length {data['units_per_m']:.4g} units and "
        f"{data['concrete_m3_per_m']:.4g} m3"
    )


def html(result):
    """A result in a notebook."""
    return f"<pre>{text(result).splitlines()[0]}</pre>" + result.to_dataframe().to_html(index=False)


def plot(result, ax=None):
    """The layer coefficients against the layer; returns the Axes."""
    return figures.layer_axes([("model", sample_of(result)[1])], ax)


def save(result, folder):
    """Write layers.csv, units.csv, crest_profile.csv, result.json, poses.npz, settings.toml, scene.glb, structure.png,
    top_view.svg and report.html into a folder, which appears whole; returns its Path."""
    with folders.result_folder(folder) as partial:
        write(result, partial)
    return Path(folder)


load = load_placement


def write(result, folder):
    """All files of a result into an existing, empty folder; elsewhere where that fails, see `folders.keep`."""

    def write_into(place):
        write_numbers(result, place)
        scene = figures.scene_of(result)
        drawing.draw_scene(scene, place / "structure.png")
        drawing.write_glb(place / "scene.glb", scene)
        folders.write_text(place / "top_view.svg", top_view.svg(result))
        folders.write_text(place / "report.html", report_page(result))

    folders.keep(write_into, folder, folders.to_json(result.to_dict()))


def notes(result):
    """What a reader must know beside the table: one sentence each."""
    found, dn, bed = [], result.test.unit.nominal_diameter, result.test.bottom
    if getattr(bed, "points", None) is not None:
        off, most = (or_dash(length, ".3g") for length in bed.misfit)
        found.append(
            f"bed interpolated from {len(bed.points)} scattered points on a grid of {bed.x[1] - bed.x[0]:.3g} m: at the points "
            f"it is off by {off} m rms, {most} m at most"
        )
    if result.fallen_layers:
        layers = ", ".join(map(str, result.fallen_layers))
        found.append(f"no structure: layer {layers} carries no plate, and most of its units fell, move or hang in the air")
    absent, known = np.flatnonzero(np.isnan(result.heights)) + 1, np.flatnonzero(np.isfinite(result.heights)) + 1
    if len(absent):
        last = f"layer {known[-1]} is {result.heights[known[-1] - 1]:.3f} Dn high" if len(known) else "no layer was read"
        found.append(f"no height of layer {', '.join(map(str, absent))}: no plate lies on it alone; {last}")
    if (pushed := result.records[0].pushed / dn) >= 5e-4:  # shown as 0.001
        found.append(f"first layer pushed apart by up to {pushed:.3f} Dn: its units overlapped as they were laid")
    if result.test.standing:
        found += repair_notes(result)
    for j, words in enumerate(result.carried_by, start=1):
        out = np.isnan(result.readings[j - 1])
        if out.any():
            kinds = [word for word, left in zip(words, out, strict=True) if left]
            counted = ", ".join(f"{kinds.count(kind)} on {kind}" for kind in dict.fromkeys(kinds))
            found.append(f"plates left out of layer {j}: {counted}")
    if unsolved := sum(record.unsolved_steps for record in result.records):
        steps = sum(record.steps for record in result.records)
        found.append(f"{unsolved} of {steps} steps did not reach residual {result.test.tolerance:g}")
    return [*found, *result.notices]


def repair_notes(result):
    """What a repair added, and what it could not fill."""
    standing, records = result.test.standing, result.records
    per_layer = ", ".join(f"layer {j}: {record.added}" for j, record in enumerate(records, start=1))
    found = [f"repair of {len(standing.layer)} units that stood ({standing.source}): units added to {per_layer}"]
    if hidden := sum(record.covered for record in records):
        found.append(f"{hidden} empty places lie under units that stand; nothing can be lowered into them, and they stay empty")
    if about := int((standing.layer == 0).sum()):
        found.append(f"{about} units lie about (layer 0): they are in the way as they are, and not part of the result")
    return found


def layer_groups(result):
    """What the buttons of the page hide: (name, first, end) of each layer's units, by their numbers in the scene."""
    ends = np.cumsum([len(poses) for poses in result.poses]).tolist()
    return [(f"layer {j}", first, end) for j, (first, end) in enumerate(zip([0, *ends[:-1]], ends, strict=True), start=1)]


def displacements(result):
    """What the page colours units by: how far each came to rest from its aim, in plan; none where aims are not known."""
    if not result.misses:
        return ()
    away = np.concatenate([np.linalg.norm(miss, axis=1) for miss in result.misses])
    return (drawing.Shades("distance from aim", "Dn", away),)


def report_page(result):
    """The text of the page."""
    test, data = result.test, result.to_dict()
    units = f"{test.unit.name}s" if isinstance(test.armour, str) else f"units of {test.unit.name}"
    title = f"Placement test: {data['grid']} grid, {len(result.poses)} layers of {units}"
    measured = laboratory_for(test)
    comparison = None if measured is None else compare_layers(result, measured)
    parts = [f"<h1>{markup.escape(title)}</h1>", f"<p>{markup.escape(headline(data, comparison))}</p>"]
    parts.append(f"<p>In metres: {markup.escape(in_metres(data))}.</p>")
    told = [*unit_lines(test), *notes(result)]
    parts += [f'<p class="note">{markup.escape(note[0].upper() + note[1:])}.</p>' for note in told]
    samples = [("model", sample_of(result)[1])]
    parts.append(layer_table(data["layers"], comparison))
    if comparison is not None:
        parts.append(
            f'<p class="note">Measured: {markup.escape(measured.title)}, {markup.escape(measured.source)}. '
            + markup.escape("; ".join(comparison.notes))
            + "</p>"
        )
        samples.append(("laboratory", sample_of(measured)[1]))
        printed = paper_numerical("table3" if measured.bottom_slope else "table2", grid=measured.grid)
        samples.append(("paper's numerical model", sample_of(printed)[1]))
    picture = figures.png_bytes(figures.layer_axes(samples).figure)
    parts.append(f'<img alt="layer coefficients" src="data:image/png;base64,{base64.b64encode(picture).decode()}">')
    page = drawing.page(figures.scene_of(result), title=title, groups=layer_groups(result), shades=displacements(result))
    parts.append(
        f'<h2>The structure</h2><iframe title="the structure, drag to turn" srcdoc="{markup.escape(page)}"></iframe>'
        '<p class="note">One colour a layer, or, by a button, by the distance of each unit from its aim in plan.</p>'
    )
    rows = [*data["settings"].items(), *((f"version of {name}", value) for name, value in data["versions"].items() if value)]
    parts.append(f"<details><summary>Settings and versions</summary>{_table(('setting', 'value'), rows)}</details>")
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><title>{markup.escape(title)}</title>'
        f"<style>{STYLE}</style></head><body>{''.join(parts)}</body></html>\n"
    )


def headline(data, comparison):
    """The result in two sentences."""
    lost = sum(row["lost"] for row in data["layers"])
    unsettled = sum(row["unsettled"] for row in data["layers"])
    units, rest = sum(row["units"] for row in data["layers"]), f"{unsettled} had not" if unsettled else "all had"
    stand = (
        f"{units} units stand {data['height_over_dn']:.3f} Dn high"
        if data["structure"]
        else f"{units} units were placed and left no structure that could be measured to its top"
    )
    text = (
        f"{stand}; {lost or 'none'} fell out of their layer, {rest} come to rest, and the deepest overlap was "
        f"{data['max_penetration_over_dn']:.1e} Dn. Porosity {or_dash(data['achieved_porosity'], '.3f')} and packing "
        f"density {or_dash(data['achieved_packing_density'], '.3f')} where the units came to rest, "
        f"{or_dash(data['porosity'], '.3f')} and {data['packing_density']:.3f} nominal."
    )
    if comparison is not None:
        text += (
            f" Against the laboratory the layer coefficients miss by {percent(comparison.mean_relative_error)} % "
            f"on average, the height by {percent(comparison.height_error, '+.2f')} %."
        )
    return text


LAYER_COLUMNS = {
    "plates": "readings",
    "plates left out": "unsupported_readings",
    "units": "units",
    "lost": "lost",
    "unsettled": "unsettled",
}


def layer_table(layers, comparison=None):
    """The layers as an HTML table, beside the measurement where there is one."""
    counts = [tuple(layer[key] for key in LAYER_COLUMNS.values()) for layer in layers]
    if comparison is None:
        rows = [(layer["layer"], or_dash(layer["k"], ".3f"), *count) for layer, count in zip(layers, counts, strict=True)]
        return _table(("layer", "k", *LAYER_COLUMNS), rows)
    rows = [
        (
            row["layer"],
            or_dash(row["mean"], ".3f"),
            f"{row['measured_mean']:.3f}",
            percent(row["signed_error"], "+.2f"),
            or_dash(row["z"], "+.1f"),
            *count,
        )
        for row, count in zip(comparison.layer_rows(), counts, strict=False)
    ]
    total = or_dash(comparison.model.mean.sum(), ".3f"), f"{comparison.measured.mean.sum():.3f}"
    rows.append(("sum", *total, percent(comparison.height_error, "+.2f"), *[""] * 6))
    return _table(("layer", "k, model", "k, laboratory", "error %", "z", *LAYER_COLUMNS), rows)


def _table(head, rows):
    cells = "".join(f"<th>{markup.escape(str(name))}</th>" for name in head)
    body = "".join("<tr>" + "".join(f"<td>{markup.escape(str(value))}</td>" for value in row) + "</tr>" for row in rows)
    return f'<div class="scroll"><table><thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table></div>'

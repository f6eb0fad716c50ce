"""The report of a placement test: one page that opens offline, with the numbers, a plot, and the structure to turn."""

import base64
import html

from hlcs.files import folders
from hlcs.placement import figures
from hlcs.placement.comparison import compare_layers, laboratory_for, percent, sample_of
from hlcs.placement.placement_file import placement_table
from hlcs.placement.placement_result import or_dash
from hlcs.placement.printed_tables import paper_numerical
from minibullet.report import drawing

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 62em; margin: 2em auto; padding: 0 1em }
table { border-collapse: collapse; margin: 1em 0 } th, td { padding: .2em .9em; text-align: right; border-bottom: 1px solid #ddd }
th { font-weight: 600 } td:first-child, th:first-child { text-align: left }
iframe { width: 100%; height: 32em; border: 1px solid #ddd } img { max-width: 100%; height: auto }
.note { color: #666 } details { margin: 1em 0 }
"""


def write_pictures(result, folder):
    """structure.png and scene.glb into an existing folder."""
    scene = figures.scene_of(result)
    drawing.draw_scene(scene, folder / "structure.png")
    drawing.write_glb(folder / "scene.glb", scene)


def write_report(result, folder):
    """report.html into an existing folder."""
    folders.write_text(folder / "report.html", report_page(result))


def report_page(result):
    """The text of the page."""
    test, data = result.test, result.to_dict()
    title = f"Placement test: {data['grid']} grid, {len(result.poses)} layers of {test.unit.name}s"
    measured = laboratory_for(test)
    parts = [f"<h1>{html.escape(title)}</h1>", f"<p>{html.escape(headline(result, measured))}</p>"]
    parts += [f'<p class="note">{html.escape(note[0].upper() + note[1:])}.</p>' for note in result.notes()]
    samples = [("model", sample_of(result)[1])]
    if measured is None:
        parts.append(layer_table(data))
    else:
        comparison = compare_layers(result, measured)
        parts.append(comparison_table(comparison, data))
        parts.append(
            f'<p class="note">Measured: {html.escape(measured.title)}, {html.escape(measured.source)}. '
            + html.escape("; ".join(comparison.notes))
            + "</p>"
        )
        samples.append(("laboratory", sample_of(measured)[1]))
        printed = paper_numerical("table3" if measured.bottom_slope else "table2", grid=measured.grid)
        samples.append(("paper's numerical model", sample_of(printed)[1]))
    picture = figures.png_bytes(figures.layer_axes(samples).figure)
    parts.append(f'<img alt="layer coefficients" src="data:image/png;base64,{base64.b64encode(picture).decode()}">')
    page = drawing.page(figures.scene_of(result), title=title)
    parts.append(
        f'<h2>The structure</h2><iframe title="the structure, drag to turn" srcdoc="{html.escape(page)}"></iframe>'
        '<p class="note">One colour a layer.</p>'
    )
    parts.append(settings_table(test, data))
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
        f"<style>{STYLE}</style></head><body>{''.join(parts)}</body></html>\n"
    )


def headline(result, measured):
    """The result in two sentences."""
    data = result.to_dict()
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
    if measured is not None:
        comparison = compare_layers(result, measured)
        text += (
            f" Against the laboratory the layer coefficients miss by {percent(comparison.mean_relative_error)} % "
            f"on average, the height by {percent(comparison.height_error, '+.2f')} %."
        )
    return text


def layer_table(data):
    """The layers as an HTML table."""
    rows = [
        (
            row["layer"],
            or_dash(row["k"], ".3f"),
            row["readings"],
            row["unsupported_readings"],
            row["units"],
            row["lost"],
            row["unsettled"],
        )
        for row in data["layers"]
    ]
    return _table(("layer", "k", "plates", "plates left out", "units", "lost", "unsettled"), rows)


def comparison_table(comparison, data):
    """The layers beside the measurement as an HTML table."""
    rows = [
        (
            row.layer,
            or_dash(row.mean, ".3f"),
            f"{row.measured_mean:.3f}",
            percent(row.signed_error, "+.2f"),
            or_dash(row.z, "+.1f"),
            layer["readings"],
            layer["unsupported_readings"],
            layer["units"],
            layer["lost"],
            layer["unsettled"],
        )
        for row, layer in zip(comparison.to_dataframe().itertuples(), data["layers"], strict=False)
    ]
    rows.append(
        (
            "sum",
            or_dash(comparison.model.mean.sum(), ".3f"),
            f"{comparison.measured.mean.sum():.3f}",
            percent(comparison.height_error, "+.2f"),
            "",
            "",
            "",
            "",
            "",
            "",
        )
    )
    return _table(
        ("layer", "k, model", "k, laboratory", "error %", "z", "plates", "plates left out", "units", "lost", "unsettled"), rows
    )


def settings_table(test, data):
    """Settings and versions, folded away."""
    rows = [*placement_table(test).items(), *((f"version of {name}", value) for name, value in data["versions"].items() if value)]
    return f"<details><summary>Settings and versions</summary>{_table(('setting', 'value'), rows)}</details>"


def _table(head, rows):
    cells = "".join(f"<th>{html.escape(str(name))}</th>" for name in head)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(str(value))}</td>" for value in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table>"

"""`index.html` of `hlcs reproduce all`: every table and figure of the paper beside ours, one page that opens offline."""

import html

from hlcs.paper import figure_list
from hlcs.paper.figure_list import Entry

TITLES = {
    "table1": "Table 1: what each parameter does",
    "table2": "Table 2 and Fig. 9: horizontal bottom",
    "table3": "Table 3 and Fig. 12: bottom of 4 %",
    "blind": "Section 4: blind reference",
    "figures": "The true unit beside its convex hull",
}
PICTURES = {"table1": "sensitivity.png", "table2": "table2.png", "table3": "table3.png", "figures": "layers.png"}
STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 68em; margin: 2em auto; padding: 0 1em }
h1 { line-height: 1.2 } h2 { margin-top: 2.2em; border-top: 1px solid #ddd; padding-top: .8em }
table { border-collapse: collapse; width: 100% } th, td { padding: .35em .6em; text-align: left; border-bottom: 1px solid #ddd; vertical-align: top }
img { max-width: 100%; height: auto; display: block; margin: 1em 0 } pre { overflow-x: auto; background: #f6f5f2; padding: 1em; font-size: 13px; line-height: 1.35 }
.wide { overflow-x: auto } figure { margin: 2em 0 } figcaption { color: #555 } .note { color: #666 }
@media (max-width: 640px) {
  thead { display: none } tr { display: block; border-bottom: 1px solid #bbb; padding: .5em 0 }
  td { display: block; border: 0; padding: .1em 0 } td::before { content: attr(data-name) ": "; color: #666 } pre { font-size: 10px }
}
"""  # noqa: E501


def page(documents, texts, seconds=None):
    """The text of the page; documents, texts: {name: ...} of the tables of `hlcs reproduce`; seconds: what all took."""
    drawn = [Entry(**one) for one in documents["figures"]["drawings"]]
    entries = figure_list.in_order([*figure_list.NOT_REDRAWN, *drawn, *figure_list.plotted_entries(documents)])
    took = f" Made in {seconds / 60:.1f} minutes." if seconds is not None else ""
    settings = documents["table2"]["settings"]
    parts = [
        "<h1>The paper again</h1>",
        "<p>J. Molines, R. Centi, M. Di Risio, J. R. Medina (2021), Coastal Engineering, doi:10.1016/j.coastaleng.2021.103901. "
        f"Every table and figure, from our own runs, beside the paper's numbers.{took} Unless a line says otherwise: contact "
        f"friction {settings['friction']:g}, which is inferred, and margin {settings['margin']:g} Dn.</p>",
        "<h2>Where every figure is</h2>",
        _table(("figure", "where", "ours", "paper's"), [_row(entry) for entry in entries]),
    ]
    for name, title in TITLES.items():
        parts.append(f'<h2 id="{name}">{html.escape(title)}</h2>{_picture(PICTURES.get(name), title)}')
        parts.append(f"<pre>{html.escape(texts[name].strip())}</pre>")
    parts.append("<h2>The figures</h2>")
    parts += [_figure(entry) for entry in entries if entry.file and entry.file not in PICTURES.values()]
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>The paper again</title>'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>{STYLE}</style></head>'
        f"<body>{''.join(parts)}</body></html>\n"
    )


def _row(entry):
    """The cells of an entry in the table of figures."""
    where = f'<a href="{_target(entry)}">{html.escape(entry.shows)}</a>' if entry.file else html.escape(entry.shows)
    return html.escape(entry.figure), where, html.escape(entry.ours), html.escape(entry.paper)


def _target(entry):
    """Where on the page an entry is shown."""
    return next((f"#{name}" for name, picture in PICTURES.items() if picture == entry.file), f"#{entry.file}")


def _figure(entry):
    """The section of one figure."""
    more = ' <a href="falling_layer.html">With a slider for the time</a>.' if entry.file.endswith(".gif") else ""
    return (
        f'<figure id="{entry.file}">{_picture(entry.file, entry.shows)}<figcaption><b>{html.escape(entry.figure)}</b>, '
        f"{html.escape(entry.shows)}. Ours: {html.escape(entry.ours)}. The paper's: {html.escape(entry.paper)}.{more}"
        "</figcaption></figure>"
    )


def _picture(file, words):
    return f'<img src="{file}" alt="{html.escape(words)}">' if file else ""


def _table(head, rows):
    """An HTML table of cells that are HTML already; each cell knows the name of its column, for narrow screens."""
    names = "".join(f"<th>{html.escape(name)}</th>" for name in head)
    body = "".join(
        "<tr>" + "".join(f'<td data-name="{name}">{cell}</td>' for name, cell in zip(head, row, strict=True)) + "</tr>"
        for row in rows
    )
    return f"<table><thead><tr>{names}</tr></thead><tbody>{body}</tbody></table>"

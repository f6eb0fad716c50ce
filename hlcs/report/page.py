"""Reports as HTML: a piece for a notebook, and one page that opens offline, on a screen, a phone and in print, light and dark.

Everything is in the one file: no script, no font and no picture is fetched.
"""

import base64
import html
import io

from hlcs.report.document import Lines, Points, Table
from hlcs.report.glossary import used_in

STYLE = """
:root{color-scheme:light dark;--ink:#1d2329;--dim:#5b6570;--paper:#fff;--card:#f5f6f4;--line:#d8dcdf;--mark:#e4eef5;
--accent:#1c5a85}
@media (prefers-color-scheme:dark){:root{--ink:#e4e7ea;--dim:#a2abb4;--paper:#14181c;--card:#1e242a;--line:#37414a;--mark:#1f3444;
--accent:#7fb8dd}}
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.55 system-ui,-apple-system,"Segoe UI",sans-serif}
main{max-width:68rem;margin:0 auto;padding:1.2rem 1rem 3rem}
h1{font-size:1.45rem;line-height:1.25;margin:.2rem 0 .8rem}
h2{font-size:1.15rem;margin:2.2rem 0 .6rem;padding-top:.9rem;border-top:1px solid var(--line)}
h3{font-size:1rem;margin:1.4rem 0 .4rem}
p,ul,dl{max-width:46rem;margin:.5rem 0;overflow-wrap:anywhere}
ul{padding-left:1.2rem} li{margin:.25rem 0}
.lead{font-size:1.12rem} .lead p,.lead ul{margin:.6rem 0}
.verdict{display:inline-block;padding:.1rem .7rem;border-radius:1rem;background:var(--accent);color:var(--paper);font-size:.85rem;
font-weight:600}
.facts{display:grid;grid-template-columns:repeat(auto-fit,minmax(9.5rem,1fr));gap:.6rem;margin:1.1rem 0;padding:0;
list-style:none;max-width:none}
.facts li{background:var(--card);border-radius:.5rem;padding:.5rem .9rem;margin:0}
.facts b{display:block;font-size:1.2rem} .facts span,.note,figcaption{color:var(--dim);font-size:.88rem}
.scroll{overflow-x:auto;margin:.7rem 0;-webkit-overflow-scrolling:touch}
table{border-collapse:collapse;font-size:.92rem;font-variant-numeric:tabular-nums}
th,td{padding:.28rem .9rem .28rem 0;border-bottom:1px solid var(--line);text-align:right;vertical-align:top;white-space:nowrap}
th{color:var(--dim);font-weight:600;white-space:normal;min-width:7rem;vertical-align:bottom}
.word{text-align:left} td.long{white-space:normal;min-width:18rem} tr.found td{background:var(--mark);font-weight:600}
pre{white-space:pre-wrap;overflow-wrap:anywhere;background:var(--card);border-radius:.4rem;padding:.7rem .9rem;font-size:.85rem;
line-height:1.45}
.figures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,24rem),1fr));gap:1rem;margin:1rem 0;
align-items:start}
figure{margin:0;background:var(--card);border-radius:.5rem;padding:.5rem}
figure img{display:block;width:100%;height:auto;background:#fff;border-radius:.3rem} figcaption{padding:.4rem .2rem .1rem}
summary{cursor:pointer;font-weight:600;padding:.5rem 0} dt{font-weight:600;margin-top:.6rem} dd{margin:0}
a{color:var(--accent)} nav{display:flex;flex-wrap:wrap;gap:.2rem .9rem;font-size:.9rem;color:var(--dim)}
@media (max-width:40rem){table{font-size:.84rem} th,td{white-space:normal;min-width:0;padding-right:.55rem}
td.word{min-width:5.2rem} td.word:first-child{min-width:6.2rem}
.wordy,.wordy tbody,.wordy tr{display:block} .wordy thead{display:none}
.wordy tr{padding:.4rem 0;border-bottom:1px solid var(--line)}
.wordy td{display:inline-block;border:0;padding:.1rem .9rem .1rem 0;text-align:left;min-width:0} .wordy td.long{display:block}
.wordy td:first-child{display:block;font-weight:600} .wordy tr.found{background:var(--mark)}
.wordy td[data-head]::before{content:attr(data-head) " ";color:var(--dim);
font-weight:400}}
@media print{details>*{display:block} figure{break-inside:avoid}}
"""
SHOWN_WITH = {  # pictures beside the sections that they belong to
    "opening": ("fit", "error"),
    "law": ("law",),
    "ranking": ("ranking",),
}
RESOLUTION = 150  # of pictures [dots an inch]


def png(axes, resolution=RESOLUTION):
    """The figure of these Axes as PNG bytes."""
    buffer = io.BytesIO()
    axes[0].figure.savefig(buffer, format="png", dpi=resolution)
    return buffer.getvalue()


def fragment(title, sections, details=(), picture=None):
    """A piece of HTML for a page of somebody else's, as a notebook is: sections, folded details, a picture (PNG bytes)."""
    image = "" if picture is None else f'<img alt="{html.escape(title)}" src="{_data(picture)}">'
    style = (
        "<style>.hlcs-report table{border-collapse:collapse}.hlcs-report .scroll,.hlcs-report pre{overflow-x:auto}"
        ".hlcs-report td,.hlcs-report th{padding:.15em .8em .15em 0;text-align:right}.hlcs-report .word{text-align:left}"
        ".hlcs-report tr.found td{font-weight:600}.hlcs-report img{max-width:100%;height:auto}</style>"
    )
    told = "".join(_section(section, "h4") for section in sections)
    if details:
        told += f"<details><summary>Details</summary>{''.join(_section(section, 'h5') for section in details)}</details>"
    return f'<div class="hlcs-report">{style}<p><b>{html.escape(title)}</b></p>{told}{image}</div>'


def whole(title, verdict, facts, sections, details, drawn):
    """One page: title, verdict, facts [(what, value)], sections, pictures {name: (PNG bytes, caption)}, details, glossary."""
    shown, rest = [], dict(drawn)
    for section in sections:
        shown.append(_section(section, "h2"))
        if section.key == "opening":
            shown.append(_facts(facts))
        names = [name for name in SHOWN_WITH.get(section.key, ()) if name in rest]
        shown.append(_figures([(name, *rest.pop(name)) for name in names]))
    if rest:
        shown.append('<section id="residuals"><h2>What is left, in pictures</h2>')
        shown.append(_figures([(name, *picture) for name, picture in rest.items()]) + "</section>")
    folded = "".join(_section(section, "h3") for section in details)
    body = "".join(shown)
    links = [(section.key, section.title) for section in sections if section.title] + (
        [("residuals", "Pictures")] if rest else []
    )
    links += [("details", "Details"), ("glossary", "Words")]
    navigation = " ".join(f'<a href="#{key}">{html.escape(name)}</a>' for key, name in links)
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{html.escape(title)}</title><style>{STYLE}</style></head><body><main>"
        f'<span class="verdict">{html.escape(verdict.replace("_", " "))}</span><h1>{html.escape(title)}</h1>'
        f"<nav>{navigation}</nav>{body}"
        '<section id="details"><h2>Details</h2><details><summary>The statistics behind this</summary>'
        f"{folded}</details></section>"
        f"{_glossary(body + folded)}</main></body></html>\n"
    )


def _data(picture):
    return f"data:image/png;base64,{base64.b64encode(picture).decode()}"


def _facts(facts):
    items = "".join(f"<li><span>{html.escape(what)}</span><b>{html.escape(value)}</b></li>" for what, value in facts)
    return f'<ul class="facts">{items}</ul>' if facts else ""


def _figures(pictures):
    """Pictures [(name, PNG bytes, caption)] side by side where there is room."""
    told = "".join(
        f'<figure><img alt="{html.escape(name.replace("_", " "))}: {html.escape(caption)}" src="{_data(picture)}">'
        f"<figcaption>{html.escape(caption)}</figcaption></figure>"
        for name, picture, caption in pictures
    )
    return f'<div class="figures">{told}</div>' if told else ""


def _glossary(told):
    items = "".join(f"<dt>{html.escape(word)}</dt><dd>{html.escape(_signs(text))}</dd>" for word, text in used_in(told).items())
    return f'<section id="glossary"><h2>Words</h2><dl>{items}</dl></section>' if items else ""


def _section(section, level):
    head = f"<{level}>{html.escape(section.title)}</{level}>" if section.title else ""
    kind = ' class="lead"' if section.key == "opening" else ""
    return f'<section id="{section.key}"{kind}>{head}{"".join(map(_part, section.parts))}</section>'


def _signs(text):
    """The signs of print for those of a terminal."""
    return text.replace("+-", "±").replace(" - model", " − model").replace(" -> ", " → ")


def _part(part):
    if isinstance(part, Table):
        return _table(part)
    if isinstance(part, Points):
        return f"<ul>{''.join(f'<li>{html.escape(_signs(item))}</li>' for item in part.items)}</ul>"
    if isinstance(part, Lines):
        return f"<pre>{html.escape(chr(10).join(part.lines))}</pre>"
    return f"<p>{html.escape(_signs(part))}</p>"


def _table(table):
    last = len(table.head) - 1

    def cell(tag, place, text):
        long = table.wordy and place == last
        kind = ' class="word long"' if long else ' class="word"' if place < table.texts else ""
        if tag == "td" and table.wordy and place:  # on a phone each cell says what it is: there the head is not shown
            kind += f' data-head="{html.escape(table.head[place])}"'
        words = html.escape(_signs(text)).replace("_", "_<wbr>")  # a name breaks behind an underscore, not within a word
        return f"<{tag}{kind}>{words}</{tag}>"

    head = "".join(cell("th", place, text) for place, text in enumerate(table.head))
    rows = []
    for number, row in enumerate(table.rows):
        found = ' class="found"' if number in table.marked else ""
        rows.append(f"<tr{found}>{''.join(cell('td', place, text) for place, text in enumerate(row))}</tr>")
    told = " ".join([*["Shaded: found."] * bool(table.marked), *[table.note] * bool(table.note)])
    note = f'<p class="note">{html.escape(_signs(told))}</p>' if told else ""
    body = "".join(rows)
    kind = ' class="wordy"' if table.wordy else ""
    return f'<div class="scroll"><table{kind}><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>{note}'

"""One offline page: the printed report and its picture."""

import base64
import html
import io


def fragment(title, text, picture=None):
    """A piece of HTML for a page of somebody else's, as a notebook is: the printed report and a picture (PNG bytes)."""
    image = ""
    if picture is not None:
        image = f'<img alt="{html.escape(title)}" src="data:image/png;base64,{base64.b64encode(picture).decode()}">'
    return (
        '<div class="hlcs-report"><style>.hlcs-report pre{overflow-x:auto;line-height:1.35}'
        f".hlcs-report img{{max-width:100%;height:auto}}</style>{image}<pre>{html.escape(text)}</pre></div>"
    )


def as_html(title, text, picture=None):
    """One page that opens offline: the printed report and, embedded, a picture (PNG bytes)."""
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>' + html.escape(title) + "</title><style>"
        "body{font-family:system-ui,sans-serif;margin:2em auto;max-width:75em;padding:0 1em;color:#222}"
        "pre{background:#f6f6f4;padding:1em}"
        f"</style></head><body><h1>{html.escape(title)}</h1>{fragment(title, text, picture)}</body></html>"
    )


def png(axes):
    """The figure of these Axes as PNG bytes."""
    buffer = io.BytesIO()
    axes[0].figure.savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()

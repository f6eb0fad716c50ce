"""The structure from above as a drawing to scale: SVG text, one group a layer and one a unit, for drawing programs."""

import html as markup

import numpy as np

from hlcs.placement.metres import states
from minibullet import rotations
from minibullet.errors import how_many
from minibullet.report.drawing import LAYER_COLOURS

SCALES = [ten * step for ten in (1, 10, 100, 1000, 10_000) for step in (1, 2, 5)]  # 1:1, 1:2, 1:5, 1:10, ...
PAPER = 0.27  # longest side of the drawing on its paper, A4 without its rims [m]
SHADE = (0.55, 0.45)  # of a colour on a face: this much on a vertical one, so much more on one that faces upwards
TEXT = 0.0035  # height of letters on the paper [m]
ROWS = 4  # of text under the drawing
LOST, STANDING = "#b02020", "#333333"  # colour of outlines: of units that do not stand in their layer, and of those that do
BAR = (1.0, 2.0, 5.0)  # what a scale bar may measure, times a power of ten


def svg(result):
    """The text of an SVG file: plan view in metres (x to the right, y up), printed at a round scale that fits A4.

    Units are drawn from below upwards, every face that looks upwards in the colour of its layer; a unit that is lost, moves or
    hangs has a red outline. Each layer is a group "layer-2", each unit a group with its number as title.
    """
    test, dn = result.test, result.test.unit.nominal_diameter
    everything = np.concatenate(result.poses)[:, :2]
    low, high = everything.min(axis=0) - 1.2 * dn, everything.max(axis=0) + 1.2 * dn
    scale = next((scale for scale in SCALES if (high - low).max() / scale <= PAPER), SCALES[-1])
    faces = _upward_faces(test.unit.shape(test.shape))
    layers = [_layer(result, layer, faces, scale) for layer in range(1, len(result.poses) + 1)]
    width, drawing = high - low
    height = drawing + ROWS * 2.0 * TEXT * scale
    box = f"{low[0]:.4f} {-high[1]:.4f} {width:.4f} {height:.4f}"  # y of SVG points down
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{1e3 * width / scale:.2f}mm" height="{1e3 * height / scale:.2f}mm" '
            f'viewBox="{box}" font-family="sans-serif" stroke-linejoin="round">',
            f"<title>{markup.escape(_title(result, scale))}</title>",
            f'<rect x="{low[0]:.4f}" y="{-high[1]:.4f}" width="{width:.4f}" height="{height:.4f}" fill="white"/>',
            '<g transform="scale(1,-1)">',
            *layers,
            "</g>",
            *_legend(result, scale, (low[0], -low[1]), width),
            "</svg>\n",
        ]
    )


def _title(result, scale):
    test = result.test
    size = f"Dn {test.unit.nominal_diameter:.4g} m"
    return f"{test.grid.name} grid, {len(result.poses)} layers of {test.unit.name}s, {size}, seen from above, 1:{scale} on A4"


def _upward_faces(shape):
    """(corners (m, 3), normal (3,)) of every face of a solid, body frame [m]."""
    pairs = [(piece, loop, normal) for piece in shape.pieces for loop, normal in zip(piece.faces, piece.normals, strict=True)]
    return [(piece.vertices[list(loop)], normal) for piece, loop, normal in pairs]


def _layer(result, layer, faces, scale):
    """The group of a layer: its units, the lowest first."""
    poses, colour = result.poses[layer - 1], LAYER_COLOURS[(layer - 1) % len(LAYER_COLOURS)]
    words = states(result, layer)
    units = [_unit(f"{layer}.{k + 1}", words[k], poses[k], faces, colour, scale) for k in np.argsort(poses[:, 2], kind="stable")]
    return "\n".join([f'<g id="layer-{layer}">', *units, "</g>"])


def _unit(number, state, pose, faces, colour, scale):
    """The group of a unit: its upward faces from below upwards."""
    rotation, shown = rotations.matrix(pose[3:]), []
    for corners, normal in faces:
        upwards = float(rotation[2] @ normal)
        if upwards > 1e-6:
            placed = corners @ rotation.T + pose[:3]
            points = " ".join(f"{x:.4f},{y:.4f}" for x, y in placed[:, :2])
            shown.append((placed[:, 2].mean(), f'<polygon points="{points}" fill="{_shaded(colour, upwards)}"/>'))
    bad = state not in ("stands", "")
    width = (0.0004 if bad else 0.0001) * scale
    told = f"unit {number}" + (f": {state}" if bad else "")
    lines = [polygon for _, polygon in sorted(shown)]
    return f'<g stroke="{LOST if bad else STANDING}" stroke-width="{width:.4f}"><title>{told}</title>{"".join(lines)}</g>'


def _shaded(colour, upwards):
    channels = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return "#" + "".join(f"{round(channel * (SHADE[0] + SHADE[1] * upwards)):02x}" for channel in channels)


def _legend(result, scale, corner, width):
    """Colours of the layers, a scale bar, the axes and what is drawn; corner: (left, top) of the strip, in drawing metres."""
    letter, (left, top) = TEXT * scale, corner
    left = left + letter
    most = 0.25 * width
    bar = max(step * 10.0**power for step in BAR for power in range(-4, 5) if step * 10.0**power <= most)
    lines = [_words(left, top + 1.2 * letter, letter, _title(result, scale).replace(" on A4", ""))]
    place = left
    for layer in range(1, len(result.poses) + 1):
        colour = LAYER_COLOURS[(layer - 1) % len(LAYER_COLOURS)]
        lines.append(
            f'<rect x="{place:.4f}" y="{top + 2.2 * letter:.4f}" width="{letter:.4f}" height="{letter:.4f}" fill="{colour}"/>'
        )
        lines.append(_words(place + 1.3 * letter, top + 3.05 * letter, letter, f"layer {layer}"))
        place += 6.0 * letter
    y = top + 5.0 * letter
    lines.append(f'<path d="M{left:.4f} {y:.4f}h{bar:.4f}" stroke="#222" stroke-width="{0.15 * letter:.4f}"/>')
    lines.append(_words(left + bar + 0.5 * letter, y + 0.35 * letter, letter, f"{bar:g} m; x to the right, y upwards"))
    odd = sum(state in ("lost", "moves or hangs") for layer in range(len(result.poses)) for state in states(result, layer + 1))
    if odd:
        told = f"red outline: {how_many(odd, 'unit')} not standing in the layer"
        lines.append(_words(left, top + 7.0 * letter, letter, told, LOST))
    return lines


def _words(x, y, size, text, colour="#222"):
    return f'<text x="{x:.4f}" y="{y:.4f}" font-size="{size:.4f}" fill="{colour}">{markup.escape(text)}</text>'

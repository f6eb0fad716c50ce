"""A placement result in metres, for drawings and reports: every unit where it came to rest, and the profile of the crest.

Levels are above the datum z = 0: of a surveyed bed that of its survey, of a slope its middle. x runs along the structure (along
the rows of units), y across it.
"""

import numpy as np

from hlcs.placement.sea_bottom import height_above
from minibullet import rotations

SAMPLES = 10  # of the upper surface along x and y on a length of one Dn
SIDEWAYS = 1e-9  # a face whose unit normal has a smaller vertical part is vertical
STATES = ("stands", "lost", "moves or hangs")


def headings(orientations):
    """Direction in plan of that axis of each unit's body which lies flattest, anticlockwise from +x: (n,) [degrees], 0 to 180.

    orientations: (n, 4). A unit with the symmetry of the cube has no front; its flattest axis is the line that shows from above.
    """
    axes = np.swapaxes(rotations.matrix(np.reshape(orientations, (-1, 4))), 1, 2)  # row k: body axis k in the world
    flattest = np.argmin(np.abs(axes[:, :, 2]).round(9), axis=1)  # of equally flat ones the first
    x, y, _ = axes[np.arange(len(axes)), flattest].T
    return np.degrees(np.arctan2(y, x)) % 180.0


def unit_rows(result):
    """Every unit as a dictionary: number ("2.17": the 17th of layer 2, in the order of placing), layer, position x_m, y_m, z_m of
    its centre, heading_deg (see `headings`), state ("stands", "lost": fell out of its layer, or "moves or hangs": was not at rest
    or carried by nothing when its layer was fixed; blank in results of earlier versions), orientation qw, qx, qy, qz."""
    return [
        {
            "number": f"{layer}.{number}",
            "layer": layer,
            **dict(zip(("x_m", "y_m", "z_m"), pose[:3].tolist(), strict=True)),
            "heading_deg": float(heading),
            "state": state,
            **dict(zip(("qw", "qx", "qy", "qz"), pose[3:].tolist(), strict=True)),
        }
        for layer, poses in enumerate(result.poses, start=1)
        for number, (pose, heading, state) in enumerate(
            zip(poses, headings(poses[:, 3:]), states(result, layer), strict=True), start=1
        )
    ]


def states(result, layer):
    """One of STATES for every unit of a layer (numbered from 1); "" where an earlier version did not keep it."""
    inside = result.in_layer[layer - 1]
    if not result.standing:
        return ["" if there else STATES[1] for there in inside]
    pairs = zip(inside, result.standing[layer - 1], strict=True)
    return [STATES[1] if not there else STATES[0] if stands else STATES[2] for there, stands in pairs]


def upper_surface(pieces, x, y, bed):
    """Level of the highest solid over each point of a grid x (m,), y (n,) [m]: (n, m) [m].

    pieces: flat-faced ConvexPiece in the world frame; bed: (n, m) level of the bed [m]. A convex solid n . p <= d has over a
    point (x, y) the top min (d - n_x x - n_y y) / n_z over its upward faces, and the bottom likewise over those downwards;
    where the top lies below the bottom, the point is beside it.
    """
    surface = np.array(bed, dtype=float)
    for piece in pieces:
        low, high = piece.vertices.min(axis=0), piece.vertices.max(axis=0)
        columns = slice(*np.searchsorted(x, (low[0], high[0])))
        rows = slice(*np.searchsorted(y, (low[1], high[1])))
        grid_x, grid_y = np.meshgrid(x[columns], y[rows])
        if grid_x.size == 0:
            continue
        (n_x, n_y, n_z), left = piece.normals.T[:, :, None, None], piece.offsets[:, None, None]
        left = left - n_x * grid_x - n_y * grid_y
        upright = np.abs(piece.normals[:, 2]) < SIDEWAYS
        with np.errstate(divide="ignore", invalid="ignore"):
            level = left / n_z
        top = np.min(level, axis=0, where=(n_z > 0.0) & ~upright[:, None, None], initial=np.inf)
        bottom = np.max(level, axis=0, where=(n_z < 0.0) & ~upright[:, None, None], initial=-np.inf)
        over = (top >= bottom) & np.all(left[upright] >= 0.0, axis=0)
        surface[rows, columns] = np.where(over, np.maximum(surface[rows, columns], top), surface[rows, columns])
    return surface


def crest_profile(result):
    """The structure in cross-section, as columns over y: y_m, bed_m, mean_m, highest_m (k,) [m].

    Mean and highest level along x of the upper surface (gaps between units show the units, or the bed, under them), over that
    length on which the last layer stands; a tenth of Dn from one point to the next.
    """
    dn, crest = result.test.unit.nominal_diameter, result.poses[-1][result.in_layer[-1]]
    if not len(crest):
        crest = result.poses[-1]
    everything = np.concatenate(result.poses)
    x = _samples(crest[:, 0].min(), crest[:, 0].max(), dn)
    y = _samples(everything[:, 1].min() - dn, everything[:, 1].max() + dn, dn)
    bed = 0.0 - height_above(result.test.bed, np.stack([*np.meshgrid(x, y), np.zeros((len(y), len(x)))], axis=-1))
    surface = upper_surface(placed_pieces(result), x, y, bed)
    return {"y_m": y, "bed_m": bed.mean(axis=1), "mean_m": surface.mean(axis=1), "highest_m": surface.max(axis=1)}


def placed_pieces(result):
    """The convex pieces of every unit where it came to rest, lowest layer first."""
    shape = result.test.unit.shape(result.test.shape)
    return [piece.moved(pose[:3], pose[3:]) for poses in result.poses for pose in poses for piece in shape.pieces]


def _samples(low, high, nominal_diameter):
    return np.linspace(low, high, max(1, int(np.ceil(SAMPLES * (high - low) / nominal_diameter))) + 1)

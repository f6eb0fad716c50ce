"""A small software renderer: solids in, an image out. NumPy only, so a picture needs neither a window nor a GPU.

Each visible face is filled into a depth buffer, which gives exact visibility; then faces are shaded, edges drawn, and
places deeper than their surroundings darkened (T. Luft et al., Image enhancement by unsharp masking the depth buffer,
ACM Trans. Graphics 25 (2006) 1206-1213), which is what makes hollows look like hollows.
"""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import uniform_filter

SUN = np.array([-0.45, -0.35, 0.82]) / np.linalg.norm([-0.45, -0.35, 0.82])
DISTANCE = 3.2  # of the eye from the middle of the scene, in radii of the scene
FAR = 1000.0  # so far away parallel lines stay parallel, and lengths alike, to a thousandth
FILLED = 0.94  # of the width or height of an image, whichever is filled first


class Solid(NamedTuple):
    """A body to be drawn."""

    vertices: np.ndarray  # (v, 3) m, world
    faces: tuple  # loops of vertex indices, counter-clockwise from outside, convex
    colour: tuple  # red, green, blue from 0 to 1


class Faces(NamedTuple):
    """All faces that look at the eye, f of them."""

    corners: list  # of (k, 2) pixels
    plane: np.ndarray  # (f, 3): 1/depth = plane . (column, row, 1)
    normal: np.ndarray  # (f, 3) world
    colour: np.ndarray  # (f, 3)
    solid: np.ndarray  # (f,) which solid


def render(solids, width=1200, height=800, azimuth=-60.0, elevation=28.0, supersample=2, distance=DISTANCE, around=None):
    """An image (height, width, 4), red green blue alpha from 0 to 1, of solids seen from azimuth, elevation [degrees]; distance:
    of the eye from the middle of the scene, in radii of the scene; around: solids that the image is fitted to, these where left
    out."""
    width, height = supersample * width, supersample * height
    faces = _visible(solids, width, height, np.radians(azimuth), np.radians(elevation), distance, around or solids)
    inverse_depth, number = _fill(faces, width, height)
    return _shaded(faces, inverse_depth, number, max(3, height // 25), supersample)


def view_axes(azimuth, elevation):
    """Right, down and forward in world axes (3, 3) of an eye at azimuth, elevation [rad] that looks at the middle."""
    back = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    return np.array([right, np.cross(right, back), -back])


def extent_seen(solids, azimuth, elevation):
    """What solids take up in a view from azimuth, elevation [degrees] so far away that lines stay parallel: lowest and highest
    place to the right and upwards, (left, right, bottom, top) [m]; the world's origin is at (0, 0)."""
    right, down, _ = view_axes(np.radians(azimuth), np.radians(elevation))
    points = np.concatenate([solid.vertices for solid in solids])
    x, y = points @ right, -(points @ down)
    return x.min(), x.max(), y.min(), y.max()


def _visible(solids, width, height, azimuth, elevation, distance, around):
    points = np.concatenate([solid.vertices for solid in around])
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    radius = np.sqrt(np.max(np.sum(np.square(points - middle), axis=1)))
    axes = view_axes(azimuth, elevation)
    eye = middle - distance * radius * axes[2]

    # Fit everything into the image with a margin of 3 %.
    seen = (points - eye) @ axes.T
    plan = seen[:, :2] / seen[:, 2:]
    low, high = plan.min(axis=0), plan.max(axis=0)
    scale = FILLED * min(width / (high[0] - low[0]), height / (high[1] - low[1]))
    shift = 0.5 * np.array([width, height]) - scale * 0.5 * (low + high)

    corners, planes, normals, colours, owners = [], [], [], [], []
    for index, solid in enumerate(solids):
        body = (solid.vertices - eye) @ axes.T
        pixels = scale * body[:, :2] / body[:, 2:] + shift
        normal, offset = _planes(body, solid.faces)
        size = np.sqrt(np.sum(normal * normal, axis=1))
        towards = np.flatnonzero(offset < -1e-9 * size * radius)  # the others look away, or are seen edge-on
        # normal . (x, y, z) = offset with x/z = (column - shift)/scale gives 1/z in pixels.
        per_pixel = normal[towards, :2] / scale
        planes.append(np.column_stack([per_pixel, normal[towards, 2] - per_pixel @ shift]) / offset[towards, None])
        corners += [pixels[list(solid.faces[face])] for face in towards]
        normals.append(normal[towards] @ axes / size[towards, None])
        colours.append(np.tile(np.asarray(solid.colour, dtype=float), (len(towards), 1)))
        owners.append(np.full(len(towards), index))
    return Faces(corners, *map(np.concatenate, (planes, normals, colours, owners)))


def _planes(vertices, loops):
    """Area vectors (f, 3), twice the area long, and offsets normal . vertex (f,) of faces of vertices (v, 3)."""
    fans = [(loop[0], second, third) for loop in loops for second, third in zip(loop[1:-1], loop[2:], strict=True)]
    first, second, third = vertices[np.array(fans).T]
    (ax, ay, az), (bx, by, bz) = (second - first).T, (third - first).T
    triangles = np.column_stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
    start = np.cumsum([0, *(len(loop) - 2 for loop in loops[:-1])])
    normals = np.add.reduceat(triangles, start)
    return normals, np.sum(normals * first[start], axis=1)


def _fill(faces, width, height):
    """1/depth (height, width), zero where nothing is, and the number of the face seen, -1 where nothing is."""
    inverse_depth, number = np.zeros((height, width)), np.full((height, width), -1, dtype=np.int32)
    nearest = [np.max(corners @ plane[:2]) + plane[2] for corners, plane in zip(faces.corners, faces.plane, strict=True)]
    for index in np.argsort(nearest)[::-1]:  # the nearest first: most of the others are then found hidden at once
        corners, plane = faces.corners[index], faces.plane[index]
        left, top = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
        right, bottom = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, (width, height))
        if left >= right or top >= bottom:
            continue
        x, y = np.arange(left, right) + 0.5, (np.arange(top, bottom) + 0.5)[:, None]
        nearer = plane[0] * x + plane[1] * y + plane[2]
        window = inverse_depth[top:bottom, left:right]
        inside = nearer > window
        if not inside.any():
            continue
        for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            # Rows count downwards, so what turns left in the world turns right in the image.
            inside &= (x1 - x0) * (y - y0) <= (y1 - y0) * (x - x0)
        window[inside] = nearer[inside]
        number[top:bottom, left:right][inside] = index
    return inverse_depth, number


def _shaded(faces, inverse_depth, number, window, supersample):
    """Colours (rows, columns, 4) from the depth buffer: `supersample` squared of its places make one."""
    seen = number >= 0
    brightness = _darkened_hollows(seen, inverse_depth, window)
    _draw_edges(brightness, faces, number)
    sun = np.clip(faces.normal @ SUN, 0.0, 1.0)
    light = faces.colour * (0.50 + 0.16 * faces.normal[:, 2] + 0.50 * sun)[:, None]
    light = np.vstack([light, np.ones(3)])  # the last of them, number -1, is the background
    image = [_averaged(np.minimum(column[number] * brightness, 1.0), supersample) for column in light.T]
    return np.stack([*image, _averaged(seen, supersample)], axis=-1)


def _darkened_hollows(seen, inverse_depth, window):
    """Brightness (rows, columns), 1 but where a place is deeper than its surroundings, a square of `window` places."""
    depth = np.divide(1.0, inverse_depth, out=np.zeros_like(inverse_depth), where=seen)
    places = np.flatnonzero(seen)
    share = np.maximum(uniform_filter(seen, window, output=float).ravel()[places], 1e-6)
    around = uniform_filter(depth, window).ravel()[places] / share
    depth = depth.ravel()[places]
    span = max(np.ptp(depth), 1e-6 * depth.max()) if len(depth) else 1.0
    # Towards the rim of the scene the surroundings are incomplete: fade out.
    strength = 0.6 * np.clip(2.5 * share - 1.5, 0.0, 1.0)
    brightness = np.ones(seen.shape)
    brightness.reshape(-1)[places] = 1.0 - strength * (1.0 - np.exp(-np.maximum(depth - around, 0.0) / (0.08 * span)))
    return brightness


def _draw_edges(brightness, faces, number):
    """Darken the places whose neighbour, to the right or below, shows another face."""
    for axis in (0, 1):
        one, two = number.ravel(), np.roll(number, -1, axis=axis).ravel()
        edge = np.flatnonzero(one != two)
        one, two = one[edge], two[edge]
        owner_differs = faces.solid[one] != faces.solid[two]
        bent = np.sum(faces.normal[one] * faces.normal[two], axis=-1) < 0.98
        line = np.where((one >= 0) != (two >= 0), 0.5, np.where(owner_differs, 0.45, np.where(bent, 0.82, 1.0)))
        brightness.reshape(-1)[edge] *= line


def _averaged(values, size):
    """The means of blocks of size x size."""
    return sum(1.0 * values[row::size, column::size] for row in range(size) for column in range(size)) / (size * size)

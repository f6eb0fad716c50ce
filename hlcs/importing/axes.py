"""From the axes of a file to those of the project: z up, right-handed, quaternions (w, x, y, z)."""

import numpy as np

from minibullet import rotations

# which axis of the file points up -> where x, y and z of the project are found in the file: (axis, sign). Each is a turn by a
# quarter or a half about an axis of the file, so a right-handed frame stays one. y up is the turn by +90 degrees about x.
AXES = {
    "z": ((0, 1), (1, 1), (2, 1)),
    "-z": ((0, 1), (1, -1), (2, -1)),
    "y": ((0, 1), (2, -1), (1, 1)),
    "-y": ((0, 1), (2, 1), (1, -1)),
    "x": ((2, -1), (1, 1), (0, 1)),
    "-x": ((2, 1), (1, 1), (0, -1)),
}
UPS = (*AXES, "none")  # "none": no axis points up; the camera looks down on the floor
ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


def turned(vectors, up):
    """Vectors of the file (n, 3), NaN where missing, in the axes of the project, z up."""
    return np.column_stack([sign * vectors[:, axis] for axis, sign in AXES["z" if up == "none" else up]])


def turned_quaternions(quaternions, up):
    """Orientations (n, 4), scalar first, of a body whose own axes are turned with those of the world.

    q' = p q p*, with p the turn of `turned`: the scalar stays, the vector part turns as a vector. What the file calls
    unturned stays unturned.
    """
    return np.column_stack([quaternions[:, 0], turned(quaternions[:, 1:], up)])


def from_euler(degrees, order):
    """Unit quaternions (n, 4) of angles (n, 3) [degrees] about x, y, z, NaN where one is missing.

    order: such as "XYZ": first about X, then about the turned Y, then about the twice turned Z (intrinsic), right-handed:
    q = q_X q_Y q_Z.
    """
    q = np.tile([1.0, 0.0, 0.0, 0.0], (len(degrees), 1))
    for letter in order:
        axis = "XYZ".index(letter)
        angle = np.radians(np.nan_to_num(degrees[:, axis : axis + 1]))
        q = rotations.product(q, rotations.exponential(angle * np.eye(3)[axis]))
    q[~np.isfinite(degrees).all(axis=1)] = np.nan
    return q

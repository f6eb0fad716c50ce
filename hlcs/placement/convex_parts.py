"""Convex pieces in place of a solid that is not convex, by CoACD (extra `units`).

X. Wei, M. Liu, Z. Ling, H. Su: Approximate convex decomposition for 3D meshes with collision-aware concavity and tree search.
ACM Transactions on Graphics 41 (2022) 42.
"""

from minibullet.errors import InputError
from minibullet.shapes.convex import ConvexPiece

# How far the surface may lie from the pieces, as CoACD measures it on a solid scaled to unit size: its own default. It cuts a
# Cubipod of one surface into 9 pieces with 0.04 % more volume; 0.01 gives 14 pieces and no better contacts.
CONCAVITY = 0.05
SEED = 0  # of its tree search: the same pieces for the same mesh


def convex_parts(vertices, triangles, name):
    """ConvexPieces in place of one closed surface, vertices (v, 3) [m], triangles (t, 3); name: what messages call it.

    InputError, with the remedies, where CoACD is not installed or finds no pieces that have a volume.
    """
    try:
        import coacd
    except ImportError:
        raise InputError(
            f"{name}: a solid that is not convex must be cut into convex pieces, for which the extra 'units' is needed: "
            "in the folder of the project, python -m pip install -e '.[units]' (or cut it yourself: closed convex pieces, one "
            "named solid or object each)"
        ) from None
    coacd.set_log_level("error")
    # "off": the surface is known to be closed, and is cut as it is, not as its remeshed copy
    found = coacd.run_coacd(coacd.Mesh(vertices, triangles), threshold=CONCAVITY, preprocess_mode="off", seed=SEED)
    try:
        return [ConvexPiece(points) for points, _ in found]
    except InputError as error:
        raise InputError(f"{name}: CoACD cut it into pieces that cannot be used ({error}); cut it yourself") from None

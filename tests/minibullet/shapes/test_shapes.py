"""Mass properties against textbook formulas, hulls against Euler, and independence of size, place and rounding."""

import itertools
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from minibullet import rotations
from minibullet.collision.packing import edge_directions
from minibullet.errors import InputError
from minibullet.shapes import polyhedra
from minibullet.shapes.primitives import Box, Capsule, Compound, ConvexPiece, Cylinder, Sphere

CUBE = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
GRID = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=3)))  # a cube with points on edges, faces and inside
ROUND = [ConvexPiece(np.random.default_rng(k).standard_normal((60, 3))) for k in range(2)]
EVERY_SHAPE = [
    Sphere(0.7),
    Box(1.0, 2.0, 3.0),
    Capsule(0.3, 1.1),
    Cylinder(0.4, 0.9),
    ConvexPiece(CUBE * (1, 2, 3) + (4, 5, 6)),
    Compound((Box(1.0, 1.0, 1.0), ConvexPiece(0.5 * CUBE + (1.0, 0.0, 0.0)))),
]


def is_a_convex_polyhedron(piece):
    """Euler's formula, every edge between two faces in opposite sense, no vertex outside any face."""
    directed = [(loop[k - 1], loop[k]) for loop in piece.faces for k in range(len(loop))]
    assert len(set(directed)) == len(directed)
    assert {(b, a) for a, b in directed} == set(directed)
    assert len(piece.vertices) - len(piece.edges) + len(piece.faces) == 2
    heights = piece.vertices @ piece.normals.T - piece.offsets
    assert heights.max() <= 2e-6 * piece.bounding_radius  # faces may be bent by the tolerance that merges triangles
    return True


# --- textbook values


def test_box_as_hull_has_the_formulas_of_the_box():
    box, hull = Box(1.0, 2.0, 3.0), Box(1.0, 2.0, 3.0).pieces[0]
    assert hull.volume == pytest.approx(6.0, rel=1e-15)
    np.testing.assert_allclose(hull.inertia, np.diag([6.5, 5.0, 2.5]), rtol=1e-15, atol=1e-15)  # V/12 (y2 + z2) ...
    np.testing.assert_allclose(box.inertia, hull.inertia, rtol=1e-15, atol=1e-15)
    assert hull.surface_area == box.surface_area == 22.0
    assert hull.bounding_radius == pytest.approx(box.bounding_radius, rel=1e-15)


def test_tetrahedron():
    """Corner tetrahedron with unit legs: V = 1/6, centre 1/4, I_xx about the centre = 1/80, I_xy = 1/480."""
    piece = ConvexPiece([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    assert piece.volume == pytest.approx(1 / 6, rel=1e-15)
    np.testing.assert_allclose(piece.centre_of_mass, [0.25] * 3, rtol=1e-15)
    np.testing.assert_allclose(piece.inertia, np.full((3, 3), 1 / 480) + np.eye(3) * (1 / 80 - 1 / 480), rtol=1e-13)
    assert piece.surface_area == pytest.approx(1.5 + np.sqrt(3) / 2, rel=1e-15)


def test_sphere_and_capsule():
    assert Sphere(2.0).volume == pytest.approx(32 / 3 * pi, rel=1e-15)
    np.testing.assert_allclose(Sphere(2.0).inertia, 0.4 * 32 / 3 * pi * 4 * np.eye(3), rtol=1e-15)
    # A capsule is a cylinder (pi) and two half balls (4/3 pi); across, half balls with their centre at 3/8 r from the base.
    capsule = Capsule(1.0, 1.0)
    across = pi * (1 / 4 + 1 / 12) + 4 / 3 * pi * (83 / 320 + (1 / 2 + 3 / 8) ** 2)
    assert capsule.volume == pytest.approx(7 / 3 * pi, rel=1e-15)
    np.testing.assert_allclose(np.diag(capsule.inertia), [pi / 2 + 4 / 3 * pi * 0.4, across, across], rtol=1e-14)


def test_prism_tends_to_the_round_cylinder_as_sides_squared():
    """A regular polygon with n corners on the circle has the area n/2 sin(2 pi/n): short by (2 pi/n)^2/6."""
    round_one = Cylinder(1.0, 2.0)
    errors = [1 - Cylinder(1.0, 2.0, sides=n).pieces[0].volume / round_one.volume for n in (64, 128)]
    np.testing.assert_allclose(errors, [(2 * pi / n) ** 2 / 6 for n in (64, 128)], rtol=3e-3)


@pytest.mark.parametrize("shape", EVERY_SHAPE, ids=lambda shape: type(shape).__name__)
def test_inertia_agrees_with_counting_points(shape, generator):
    """300 000 random points: 2 % is four standard errors for a solid that fills a tenth of the cube around it."""
    reach = shape.bounding_radius
    points = generator.uniform(-reach, reach, (300_000, 3))
    inside = np.zeros(len(points), dtype=bool)
    for piece in shape.pieces:
        if piece.faces:
            inside |= np.all(points @ piece.normals.T <= piece.offsets, axis=1)
        else:
            a, b = piece.vertices[0], piece.vertices[-1]
            along = np.clip((points - a) @ (b - a) / max((b - a) @ (b - a), 1e-300), 0, 1)
            inside |= np.linalg.norm(points - a - along[:, None] * (b - a), axis=1) <= piece.radius
    cell = (2 * reach) ** 3 / len(points)
    second = points[inside].T @ points[inside] * cell
    assert inside.sum() * cell == pytest.approx(shape.volume, rel=0.02)
    np.testing.assert_allclose(np.trace(second) * np.eye(3) - second, shape.inertia, atol=0.025 * np.trace(shape.inertia))


# --- what every shape promises


@pytest.mark.parametrize("shape", EVERY_SHAPE, ids=lambda shape: type(shape).__name__)
def test_pieces_surround_the_centre_of_mass(shape):
    total = sum(piece.volume * piece.centre_of_mass for piece in shape.pieces)
    np.testing.assert_allclose(total, np.zeros(3), atol=1e-14 * shape.volume * shape.bounding_radius)
    reach = max(np.linalg.norm(piece.vertices, axis=1).max() + piece.radius for piece in shape.pieces)
    assert reach == pytest.approx(shape.bounding_radius, rel=1e-14)


@pytest.mark.parametrize("shape", EVERY_SHAPE, ids=lambda shape: type(shape).__name__)
def test_shapes_are_values(shape):
    assert len({shape, shape}) == 1
    assert not any(piece.vertices.flags.writeable for piece in shape.pieces)


def test_hulls_compare_and_hash_by_content():
    assert ConvexPiece(CUBE) == ConvexPiece(CUBE.copy())
    assert hash(ConvexPiece(CUBE)) == hash(ConvexPiece(CUBE.copy()))
    assert ConvexPiece(CUBE) != ConvexPiece(2 * CUBE)
    assert Compound((ConvexPiece(CUBE),)) == Compound([ConvexPiece(CUBE)])


def test_inertia_turns_with_the_piece(generator):
    piece = ConvexPiece(generator.normal(size=(30, 3)))
    for q in rotations.random(generator, 5):
        r = rotations.matrix(q)
        turned = piece.moved((1.0, 2.0, 3.0), q)
        np.testing.assert_allclose(turned.inertia, r @ piece.inertia @ r.T, atol=1e-13 * np.trace(piece.inertia))
        np.testing.assert_allclose(turned.centre_of_mass, r @ piece.centre_of_mass + (1, 2, 3), atol=1e-13)


def test_principal_axes_are_those_of_the_library(generator):
    """Jacobi's rotations against LAPACK: moments to rounding, axes that make the tensor diagonal and turn without mirroring;
    equal moments, a diagonal tensor and moments apart by 1e12 too."""
    tensors = [np.diag(m) for m in ((3.0, 1.0, 2.0), (1.0, 1.0, 1.0), (2.0, 2.0, 1.0))]
    for q, moments in zip(rotations.random(generator, 60), 10.0 ** generator.uniform(-12.0, 0.0, (60, 3)), strict=True):
        moments[1] = moments[0] if q[0] > 0.5 else moments[1]
        half = rotations.matrix(q) * np.sqrt(moments)
        tensors.append(half @ half.T)
    for tensor in tensors:
        moments, axes = polyhedra.principal_axes(tensor)
        size = np.abs(tensor).max()
        np.testing.assert_allclose(moments, np.linalg.eigvalsh(tensor), rtol=0.0, atol=1e-14 * size)
        np.testing.assert_allclose(axes @ np.diag(moments) @ axes.T, tensor, rtol=0.0, atol=1e-14 * size)
        np.testing.assert_allclose(axes.T @ axes, np.eye(3), rtol=0.0, atol=1e-14)
        assert np.linalg.det(axes) > 0.0


def test_two_half_boxes_weigh_one_box():
    halves = Compound((Box(2.0, 1.0, 3.0), ConvexPiece(0.5 * CUBE * (2.0, 1.0, 3.0) + (0.0, 1.0, 0.0))))
    np.testing.assert_allclose(halves.inertia, Box(2.0, 2.0, 3.0).inertia, atol=1e-13)
    np.testing.assert_allclose(halves.centre_of_mass, [0, 0.5, 0], atol=1e-15)


def test_surface_of_touching_parts_is_the_outside():
    halves = Compound((Box(2.0, 1.0, 3.0), ConvexPiece(0.5 * CUBE * (2.0, 1.0, 3.0) + (0.0, 1.0, 0.0))))
    assert halves.surface_area == pytest.approx(Box(2.0, 2.0, 3.0).surface_area, rel=1e-14)


# --- hulls


def test_coplanar_triangles_are_one_face_and_needless_points_vanish():
    piece = ConvexPiece(GRID)
    assert sorted(map(tuple, piece.vertices)) == sorted(map(tuple, CUBE))
    assert [len(loop) for loop in piece.faces] == [4] * 6
    assert set(map(tuple, np.abs(piece.normals))) == {(1, 0, 0), (0, 1, 0), (0, 0, 1)}
    assert np.all(piece.offsets == 1.0)


@pytest.mark.parametrize("shift, kind", [(0.0, float), (1e3, float), (1e6, float), (0.0, np.float32), (3.0, np.float32)])
def test_rounded_coordinates_do_not_make_extra_faces(shift, kind, generator):
    """Points turned and moved far away, or stored with 32 bits, are no longer exactly on their edges and faces."""
    for q in rotations.random(generator, 20):
        piece = ConvexPiece((rotations.rotate(q, GRID) + shift).astype(kind))
        assert (len(piece.vertices), len(piece.faces)) == (8, 6)
        assert is_a_convex_polyhedron(piece)


@pytest.mark.parametrize("count", [4, 5, 8, 20, 200])
def test_random_hulls_are_convex_polyhedra(count, generator):
    for _ in range(20):
        assert is_a_convex_polyhedron(ConvexPiece(generator.normal(size=(count, 3))))


def test_round_and_regular_hulls_are_convex_polyhedra():
    phi = (1 + np.sqrt(5)) / 2
    corners = [(0, a, b * phi) for a in (-1, 1) for b in (-1, 1)]
    icosahedron = ConvexPiece([np.roll(c, k) for c in corners for k in range(3)])
    assert (len(icosahedron.faces), len(icosahedron.edges)) == (20, 30)
    dodecahedron = ConvexPiece(icosahedron.normals)  # its dual
    assert [len(loop) for loop in dodecahedron.faces] == [5] * 12
    prism = Cylinder(1.0, 2.0, sides=64).pieces[0]
    assert sorted(len(loop) for loop in prism.faces) == [4] * 64 + [64, 64]
    assert all(map(is_a_convex_polyhedron, (icosahedron, dodecahedron, prism)))


def regular(sides):
    """Corners of a regular prism."""
    angle = 2 * pi * np.arange(sides) / sides
    return np.concatenate([np.column_stack([np.cos(angle), np.sin(angle), np.full(sides, z)]) for z in (0.0, 1.0)])


@pytest.mark.parametrize(
    "points",
    [
        CUBE,
        GRID,
        3 * GRID @ rotations.matrix(np.array([0.5, 0.5, -0.1, 0.7])).T,
        regular(7),
        regular(300),
        regular(300).astype(np.float32),
        regular(300) * (1, 1, 1e-4),
    ],
    ids=["cube", "grid", "turned grid", "prism", "fine prism", "rounded prism", "thin prism"],
)
def test_large_hulls_have_the_faces_of_small_ones(points, monkeypatch):
    """Beyond a number of points qhull joggles them instead of merging triangles itself: the same corners, the same faces."""
    merged = ConvexPiece(points)
    monkeypatch.setattr("minibullet.shapes.polyhedra.MOST_MERGED", 0)
    joggled = ConvexPiece(points)
    assert joggled == merged and joggled.faces == merged.faces


def test_edges_of_one_direction_share_it():
    """Against the definition: the first direction known whose cosine with the edge is one within 1e-12.

    Products are summed from left to right: a library's product of two vectors is rounded as its processor likes."""
    turned = CUBE @ rotations.matrix(np.array([0.8, 0.2, -0.5, 0.3])).T
    near = GRID + 1e-7 * np.random.default_rng(2).standard_normal(GRID.shape)  # some within the tolerance, some not
    for piece in (*(ConvexPiece(points) for points in (CUBE, turned, near, regular(24), 1e-3 * regular(25))), *ROUND):
        directions, index = edge_directions(piece.vertices, piece.edges)
        expected, kept = [], []
        for first, second in piece.edges:
            line = piece.vertices[second] - piece.vertices[first]
            line = line / np.sqrt(sum(line * line))
            found = [k for k, known in enumerate(kept) if 1 - abs(sum(known * line)) < 1e-12]
            kept += [] if found else [line]
            expected.append(found[0] if found else len(kept) - 1)
        assert list(index) == expected
        assert np.array_equal(directions, kept)


@pytest.mark.parametrize("thickness", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10])
def test_thin_plates_keep_their_six_faces(thickness):
    piece = ConvexPiece(CUBE * (1, 1, thickness))
    assert len(piece.faces) == 6
    assert piece.volume == pytest.approx(8 * thickness, rel=1e-12)


@given(st.integers(-60, 60), st.integers(0, 2**32 - 1))
def test_scaling_by_a_power_of_two_changes_nothing_but_the_exponent(exponent, seed):
    """Case 42 of the validation list begins here: bit-identical, so no hidden length scale."""
    points = np.random.default_rng(seed).normal(size=(12, 3))
    small, large = ConvexPiece(points), ConvexPiece(np.ldexp(points, exponent))
    assert small.faces == large.faces
    np.testing.assert_array_equal(small.normals, large.normals)
    for name, power in (
        ("vertices", 1),
        ("offsets", 1),
        ("centre_of_mass", 1),
        ("bounding_radius", 1),
        ("surface_area", 2),
        ("volume", 3),
        ("inertia", 5),
    ):
        np.testing.assert_array_equal(np.ldexp(getattr(small, name), power * exponent), getattr(large, name), err_msg=name)
    np.testing.assert_array_equal(np.ldexp(small.pieces[0].vertices, exponent), large.pieces[0].vertices)


@pytest.mark.parametrize(
    "make",
    [
        lambda s: Sphere(0.3 * s),
        lambda s: Capsule(0.3 * s, 0.7 * s),
        lambda s: Box(0.1 * s, 0.3 * s, 0.7 * s),
        lambda s: Cylinder(0.3 * s, 0.7 * s),
    ],
    ids=["Sphere", "Capsule", "Box", "Cylinder"],
)
def test_simple_shapes_scale_bit_for_bit(make):
    one, small = make(1.0), make(2.0**-9)
    assert small.volume == np.ldexp(one.volume, -27)
    assert small.bounding_radius == np.ldexp(one.bounding_radius, -9)
    np.testing.assert_array_equal(small.inertia, np.ldexp(one.inertia, -45))


# --- refusals


@pytest.mark.parametrize(
    "points, words",
    [
        ([[0, 0, 0]], "1 point;"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "3 points; a hull needs at least 4"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], "4 points are coplanar within 1e-12 of the size"),
        ([[0, 0, 0], [1, 1, 1], [2, 2, 2], [3, 3, 3]], "coplanar"),
        ([[5.0, 5, 5]] * 6, "coplanar"),
        ([[0, 0, 0], [1, 0, 0], [0, float("nan"), 0], [0, 0, 1]], "vertex 2 = .* is not finite"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, float("inf")]], "vertex 3 = .* is not finite"),
        ([[0, 0], [1, 0], [0, 1], [1, 1]], r"shape \(4, 2\)"),
        ([], "shape"),
        ("cube", "not an array of numbers"),
        (CUBE * 1e-300, "double precision"),
        (CUBE * 1e300, "double precision"),
        (CUBE * (1, 1, 1e7), "a needle must be thicker than a millionth of its length"),
    ],
)
def test_what_is_no_hull_is_refused_by_name(points, words):
    with pytest.raises(InputError, match=words):
        ConvexPiece(points)


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: Sphere(-1.0), "sphere: radius = -1.0"),
        (lambda: Sphere(float("nan")), "sphere: radius = nan"),
        (lambda: Sphere("big"), "sphere: radius = 'big'"),
        (lambda: Sphere([1, 2]), r"sphere: radius = \[1, 2\]; must be a finite length"),
        (lambda: Sphere(True), "sphere: radius = True"),
        (lambda: Sphere(1e308), "sphere: radius = 1e[+]308; .* double precision"),
        (lambda: Sphere(1e-300), "sphere: radius = 1e-300; .* double precision"),
        (lambda: Sphere(10**200), "sphere: radius = 10+.*; .* double precision"),
        (lambda: Box(1e200, 1e200, 1.0), "box: x = 1e[+]200, y = 1e[+]200, z = 1.0; .* double precision"),
        (lambda: Box(1.0, 0.0, 1.0), "box: y = 0.0"),
        (lambda: Capsule(1.0, float("inf")), "capsule: length = inf"),
        (lambda: Cylinder(1.0, 1.0, sides=2), "cylinder: sides = 2"),
        (lambda: ConvexPiece(CUBE, radius=0.1), "8 points; only one point"),
        (lambda: ConvexPiece([[0, 0, 0], [0, 0, 0]], radius=0.1), "two different points"),
        (lambda: ConvexPiece([[0, 0, 0]], radius=-0.1), "radius = -0.1"),
        (lambda: Compound(()), "no parts"),
        (lambda: Compound((Box(1.0, 1.0, 1.0), "lid")), "part 1 is 'lid'"),
        (lambda: Compound((Box(1.0, 1.0, 1.0), Box(0.5, 0.5, 0.5))), "parts 0 and 1 overlap"),
    ],
)
def test_what_is_no_solid_is_refused_by_name(make, words):
    with pytest.raises(InputError, match=words):
        make()

"""Mesh files: good ones give the exact solid, bad ones one clear message, and nothing else ever happens."""

import os
import struct

import numpy as np
import pytest
import trimesh

from minibullet.errors import InputError
from minibullet.shapes.mesh_files import mesh_file
from minibullet.shapes.primitives import Compound, ConvexPiece

TETRAHEDRON_OBJ = """# corner of a cube
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1/7 2//3 4/1/1
f \\
  2 3 -1
f 3 1 4
"""


@pytest.fixture
def write(tmp_path):
    """A function that writes text, bytes or a trimesh into a file and returns its path."""

    def write_file(name, content, **options):
        path = tmp_path / name
        if isinstance(content, str):
            path.write_text(content)
        elif isinstance(content, bytes):
            path.write_bytes(content)
        else:
            content.export(path, **options)
        return path

    return write_file


def box(x=1.0, y=1.0, z=1.0, at=(0.0, 0.0, 0.0)):
    return trimesh.creation.box((x, y, z)).apply_translation(at)


def ascii_stl(*meshes):
    return "\n".join(trimesh.exchange.stl.export_stl_ascii(mesh) for mesh in meshes)


# --- good files


@pytest.mark.parametrize("name", ["unit.stl", "UNIT.STL", "unit.obj", "unit.ply", "unit.off"])
def test_every_format_gives_the_exact_box(name, write):
    piece = mesh_file(write(name, box(1.0, 2.0, 3.0, at=(4.0, 0.0, 0.0)), file_type=name[-3:].lower()))
    assert isinstance(piece, ConvexPiece)
    assert len(piece.faces) == 6
    assert piece.volume == pytest.approx(6.0, rel=1e-14)
    np.testing.assert_allclose(piece.centre_of_mass, [4, 0, 0], atol=1e-14)
    np.testing.assert_allclose(piece.inertia, np.diag([6.5, 5.0, 2.5]), atol=1e-13)


def test_scale_is_metres_per_unit(write):
    path = write("unit.obj", TETRAHEDRON_OBJ)
    assert mesh_file(path).volume == pytest.approx(1 / 6, rel=1e-14)
    assert mesh_file(path, scale=0.001).volume == pytest.approx(1e-9 / 6, rel=1e-14)


def test_several_solids_of_an_ascii_stl_may_touch(write):
    """Face on face, with all four corners in common: told apart by their names."""
    shape = mesh_file(write("two.stl", ascii_stl(box(), box(at=(1.0, 0.0, 0.0)))))
    assert isinstance(shape, Compound)
    assert len(shape.pieces) == 2
    assert shape.volume == pytest.approx(2.0, rel=1e-14)


def test_objects_of_an_obj_may_touch(write):
    first = TETRAHEDRON_OBJ
    second = "o mirrored\nv 0 0 0\nv -1 0 0\nv 0 1 0\nv 0 0 1\nf -4 -3 -2\nf -4 -1 -3\nf -3 -1 -2\nf -2 -1 -4\n"
    assert mesh_file(write("two.obj", first + second)).volume == pytest.approx(1 / 3, rel=1e-14)


def test_separate_solids_of_a_binary_stl_are_found(write):
    shape = mesh_file(write("two.stl", trimesh.util.concatenate([box(), box(at=(3.0, 0.0, 0.0))])))
    assert len(shape.pieces) == 2
    np.testing.assert_allclose(shape.centre_of_mass, [1.5, 0, 0], atol=1e-14)


def test_one_solid_in_several_named_parts_is_one_solid(write):
    mesh = box()
    halves = [trimesh.Trimesh(mesh.vertices, mesh.faces[part], process=False) for part in (slice(0, 5), slice(5, 12))]
    assert isinstance(mesh_file(write("parts.stl", ascii_stl(*halves))), ConvexPiece)


QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]  # a box with corners by x, y, z
CORNERS = [(x, y, z) for x in (0, 1) for y in (0, 2) for z in (0, 3)]


def rows(table):
    return "".join(" ".join(map(str, row)) + "\n" for row in table)


def test_faces_of_four_corners_are_read_in_every_format(write):
    """Of the text formats by hand, of the binary ones through struct; with what else a file may say of vertices and faces."""
    off = "# made by hand\nCOFF\n8 6 12\n" + rows((*corner, 255, 0, 0) for corner in CORNERS) + rows((4, *q, 0.5) for q in QUADS)
    obj = rows(("v", *corner, 1.0) for corner in CORNERS) + "vt 0 0\n" + rows(("f", *(f"{k + 1}/1" for k in q)) for q in QUADS)
    head = (
        ply(8, 6)
        .replace(
            "list uchar int vertex_indices",
            "uchar tint\nproperty list uchar short vertex_index\nproperty list uint8 float64 texcoord",
        )
        .replace("float z", "double z\nproperty uchar red")
    )
    head = head.replace("element vertex", "comment from a scanner\nelement camera 2\nproperty int32 id\nelement vertex")
    text = head + "7\n8\n" + rows((*corner, 255) for corner in CORNERS) + rows((9, 4, *q, 2, 0.5, 0.25) for q in QUADS)
    cases = {"unit.off": off, "unit.obj": obj, "text.ply": text}
    for name, order in (("binary_little_endian", "<"), ("binary_big_endian", ">")):
        body = struct.pack(order + "ii", 7, 8) + b"".join(struct.pack(order + "ffdB", *corner, 255) for corner in CORNERS)
        body += b"".join(struct.pack(order + "BB4hBdd", 9, 4, *q, 2, 0.5, 0.25) for q in QUADS)
        cases[f"{name}.ply"] = head.replace("ascii", name).encode() + body
    for name, content in cases.items():
        piece = mesh_file(write(name, content))
        assert (len(piece.faces), piece.volume) == (6, pytest.approx(6.0, rel=1e-14)), name


def test_faces_named_one_by_one_are_one_solid(write):
    text = rows(("v", *corner) for corner in CORNERS) + "".join(
        f"g face{k}\nf {a + 1} {b + 1} {c + 1} {d + 1}\n" for k, (a, b, c, d) in enumerate(QUADS)
    )
    assert mesh_file(write("unit.obj", text)).volume == pytest.approx(6.0, rel=1e-14)


def prism(sides, height=1):
    """OBJ text of a regular prism of circumradius 1 whose ends are one face each."""
    angle = 2 * np.pi * np.arange(sides) / sides
    circle = np.column_stack([np.cos(angle), np.sin(angle)]).tolist()
    ring = np.arange(sides)
    after = np.roll(ring, -1)
    faces = [ring[::-1], ring + sides, *np.column_stack([ring, after, after + sides, ring + sides])]
    return rows(("v", repr(x), repr(y), z) for z in (0, height) for x, y in circle) + rows(
        ("f", *(face + 1).tolist()) for face in faces
    )


def test_a_cylinder_of_24000_sides_is_read(write):
    """Volume n/2 sin(2 pi/n); sides that leave a plane by less than 1e-6 of the size are one face, which costs less than 4e-6."""
    piece = mesh_file(write("cylinder.obj", prism(24_000)))
    assert piece.volume == pytest.approx(12_000 * np.sin(2 * np.pi / 24_000), rel=4e-6)
    np.testing.assert_allclose(piece.centre_of_mass, [0, 0, 0.5], atol=4e-6)


def test_more_solids_than_can_be_used_are_counted_not_split(write):
    ball = trimesh.creation.box()
    many = trimesh.util.concatenate([ball.copy().apply_translation((3.0 * k, 0, 0)) for k in range(65)])
    with pytest.raises(InputError, match="65 separate solids, at most 64 are read; use fewer pieces"):
        mesh_file(write("many.stl", many))
    assert len(mesh_file(write("enough.stl", trimesh.util.concatenate(many.split()[:64]))).pieces) == 64


def test_a_solid_too_finely_faceted_for_its_thickness_is_refused_as_that(write):
    """A needle of 3000 sides, 1e5 times as long as wide: faces within 1e-3 of its thickness are merged."""
    with pytest.raises(InputError, match=r"holds 100\.\d+ % of its hull: .* too fine for its thickness; simplify"):
        mesh_file(write("needle.obj", prism(3_000, height=100_000)))


def test_nothing_but_the_file_itself_is_opened(write):
    path = write("unit.obj", "mtllib /nowhere/paint.mtl\nusemtl gold\n" + TETRAHEDRON_OBJ)
    assert mesh_file(path).volume == pytest.approx(1 / 6, rel=1e-14)


# --- bad files


def binary_stl(count, body=b""):
    return b"made by hand".ljust(80) + count.to_bytes(4, "little") + body


def ply(vertices, faces, form="ascii", length="uchar"):
    """The header of a PLY file."""
    return (
        f"ply\nformat {form} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {faces}\nproperty list {length} int vertex_indices\nend_header\n"
    )


BAD_FILES = {
    "lying header": (
        "unit.stl",
        binary_stl(4294967280, b"0" * 50),
        r"header announces 4294967280 triangles \(215 GB\), the file has 134 bytes; is it an ASCII STL\?",
    ),
    "cut off": ("unit.stl", binary_stl(3, b"0" * 100), "header announces 3 triangles .234 bytes., the file has 184 bytes"),
    "no bytes": ("unit.stl", b"", "the file has 0 bytes"),
    "no triangles": ("unit.stl", binary_stl(0), "no triangles; the file is empty"),
    "empty solid": ("unit.stl", "solid a\nendsolid a\n", "no triangles; the file is empty"),
    "not a number, binary": ("unit.stl", binary_stl(1, b"\xff" * 50), "triangle 1: corner .* is not finite"),
    "not a number, ascii": (
        "unit.stl",
        ascii_stl(box()).replace("vertex 0.5", "vertex nan", 1),
        r"line \d+: vertex 'nan .* is not finite",
    ),
    "infinite": ("unit.obj", "v 0 0 0\nv 1 0 1e999\n", "line 2: vertex '1 0 1e999' is not finite"),
    "half a vertex": ("unit.obj", "v 0 0 0\nv 1 0\n", "line 2: vertex '1 0'; 3 numbers are needed"),
    "letters": ("unit.obj", "v 0 0 zero\n", "line 1: vertex '0 0 zero'; 3 numbers"),
    "two corners in a loop": (
        "unit.stl",
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
        "line 6: facet with 2 vertices",
    ),
    "ends within a facet": ("unit.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "ends within a facet"),
    "strange word": ("unit.stl", "solid a\nfacette normal 0 0 1\n", "line 2: 'facette' is no word"),
    "index too large": (
        "unit.obj",
        TETRAHEDRON_OBJ + "f 1 2 999999999\n",
        "line 11: face uses vertex 999999999, but only 4 vertices are defined",
    ),
    "index beyond any integer": ("unit.obj", TETRAHEDRON_OBJ + "f 1 2 " + "9" * 30 + "\n", "line 11: face uses vertex 9999"),
    "index zero": ("unit.obj", TETRAHEDRON_OBJ + "f 0 1 2\n", "line 11: face uses vertex 0"),
    "index before the beginning": ("unit.obj", TETRAHEDRON_OBJ + "f -5 1 2\n", "line 11: face uses vertex -5"),
    "index is a word": ("unit.obj", TETRAHEDRON_OBJ + "f one 1 2\n", "line 11: face corner 'one' is no vertex number"),
    "face of two": ("unit.obj", TETRAHEDRON_OBJ + "f 1 2\n", "line 11: face with 2 vertices"),
    "endless line": ("unit.obj", "f " + "1 " * 1_200_000, "line 1: longer than 2400000 bytes"),
    "a face of too many corners": ("unit.obj", "v 0 0 0\nf " + "1 " * 100_003, "100001 triangles or more, at most 100000"),
    "index of 5000 digits": ("unit.obj", TETRAHEDRON_OBJ + "f 1 2 " + "9" * 5000 + "\n", "line 11: face corner '9+' is no"),
    "number of 400 digits": ("unit.obj", "v 0 0 " + "9" * 400 + "\n", r"line 1: vertex '0 0 9+..' is not finite"),
    "too many lines": ("unit.obj", "\n" * 2_000_001, "2000001 lines or more, at most 2000000 are read"),
    "too many vertices": ("unit.obj", "v 0 0 0\n" * 300_001, "300001 vertices or more, at most 300000"),
    "ends in a joined line": ("unit.obj", TETRAHEDRON_OBJ + "f 1 2 \\", "line 11: face with 2 vertices"),
    "triangles of no size": ("unit.obj", "v 0 0 0\nv 1 0 0\n" + "f 1 1 2\n" * 4, "all triangles have zero size"),
    "escape codes": ("unit.stl", "solid a\n\x1b[31mfacet\n", r"line 2: '\\x1b\[31mfacet' is no word"),
    "four vertices in a loop": ("unit.stl", "solid a\n" + "vertex 0 0 0\n" * 4 + "endloop\n", "line 6: facet with 4 vertices"),
    "lying PLY": (
        "unit.ply",
        "ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n",
        "line 3: 'element vertex 99999999999', the file has 59 bytes",
    ),
    "PLY without data": ("unit.ply", ply(3, 1) + "1 2 3\n", "line 3: 'element vertex 3', the file has 160 bytes; it was cut off"),
    "PLY of 1e9 faces": (
        "unit.ply",
        ply(4, 10**9, "binary_little_endian").encode() + bytes(99),
        "line 7: 'element face 1000000000', the file has 277 bytes; it was cut off",
    ),
    "PLY of too many faces": ("unit.ply", ply(0, 200_000) + "0 0\n" * 200_000, "200000 of 'face' or more, at most 100000"),
    "PLY list too long": ("unit.ply", ply(0, 2, "binary_big_endian", "uint").encode() + b"\xff" * 9, "it was cut off"),
    "PLY list of negative length": ("unit.ply", ply(0, 2, "binary_big_endian", "char").encode() + b"\xff" * 9, "it was cut off"),
    "PLY list counted in halves": ("unit.ply", ply(3, 1, length="float"), "line 8: 'property list float int vertex_indices' is"),
    "PLY face too short": ("unit.ply", ply(1, 1) + "0 0 0\n3 0 0\n", "line 11: face '3 0 0'; the number of corners must stand"),
    "PLY face of no vertex": ("unit.ply", ply(1, 1) + "0 0 0\n3 0 0 -1\n", r"line 11: face uses vertex -1 \(from 0\)"),
    "PLY vertex not finite": ("unit.ply", ply(1, 0, "binary_little_endian").encode() + b"\xff" * 12, "vertex 0 .* not finite"),
    "PLY vertex without z": ("unit.ply", ply(1, 0).replace("float z", "float w") + "0 0 0\n", "needs the properties x"),
    "PLY face without corners": ("unit.ply", ply(1, 1).replace("vertex_indices", "tints") + "0 0 0\n1 0\n", "needs one"),
    "PLY text that ends early": ("unit.ply", ply(1, 2) + "0 0 0\n3" + " " * 9, "line 11: face '3'; the number of"),
    "PLY text without its faces": ("unit.ply", ply(1, 1) + "0 0 0\n" + " " * 9, "line 7: .element face 1., .* cut off"),
    "PLY of other lists": ("unit.ply", ply(1, 1).replace("t face", "t strip") + "0 0 0\n1 0\n", "lists are read of faces only"),
    "PLY of many properties": ("unit.ply", ply(1, 1).replace("end_", "property int i\n" * 40 + "end_"), "31 properties or more"),
    "PLY of many elements": ("unit.ply", "ply\nformat ascii 1.0\n" + "element a 1\n" * 40, "31 elements or more"),
    "PLY of unknown format": ("unit.ply", ply(1, 1, "ebcdic"), "line 2: 'format ebcdic 1.0' is not readable"),
    "no PLY": ("unit.ply", "plaster", "no PLY header"),
    "no OFF": ("unit.off", "NOTHING 3 3 3\n1", "not a readable OFF file; it must begin with the word OFF"),
    "OFF in bytes": ("unit.off", "OFF BINARY\n1", "not a readable OFF file; it must begin with the word OFF and be of text"),
    "OFF without counts": ("unit.off", "OFF\n-8 6 0\n", "not a readable OFF file; '-8 6' follows OFF"),
    "OFF cut off": ("unit.off", "OFF 3 3 3\n0 0 0\n", "line 2: the file ends here, its header announces 3 vertices and 3 faces"),
    "OFF of a 400-digit count": ("unit.off", "OFF " + "9" * 400 + " 1 1\n", "9+ vertices or more, at most 300000 are read"),
    "OFF of 1e9 faces": ("unit.off", "OFF 3 1000000000 1\n", "1000000000 triangles or more, at most 100000 are read"),
    "OFF face of 1e9 corners": ("unit.off", "OFF 1 1 1\n0 0 0\n1000000000 0 0 0\n", "line 3: face '1000000000 0 0 0'; the"),
    "OFF face of half a corner": ("unit.off", "OFF 1 1 1\n0 0 0\n3 0 0 0.5\n", "line 3: face corner '0.5' is no vertex number"),
    "OFF face of no vertex": ("unit.off", "OFF 1 1 1\n0 0 0\n3 0 0 1\n", r"line 3: face uses vertex 1 \(from 0\), but only 1"),
    "no ending": ("unit", "", "mesh 'unit': no ending, which tells what is in a file; give one of .stl, .obj"),
    "unknown ending": ("unit.fbx", "", "unknown ending '.fbx'; give one of .stl, .obj"),
}


@pytest.mark.parametrize("case", BAD_FILES)
def test_bad_files_are_refused_by_name_line_and_value(case, write):
    name, content, words = BAD_FILES[case]
    with pytest.raises(InputError, match=words) as refusal:
        mesh_file(write(name, content))
    assert str(refusal.value).startswith(f"mesh '{name}'")
    assert "\n" not in str(refusal.value)


def test_missing_file_and_folder_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"cannot be read \(No such file or directory\); looked for .*gone.stl"):
        mesh_file(tmp_path / "gone.stl")
    (tmp_path / "folder.stl").mkdir()
    with pytest.raises(InputError, match="mesh 'folder.stl': is a folder; give a file"):
        mesh_file(tmp_path / "folder.stl")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="a system without pipes and devices among its files")
def test_a_file_that_never_ends_or_never_begins_is_refused_unread(tmp_path):
    """A link to /dev/zero would fill the memory; a pipe that nobody writes to would hang."""
    (tmp_path / "zero.stl").symlink_to("/dev/zero")
    os.mkfifo(tmp_path / "pipe.stl")
    for name in ("zero.stl", "pipe.stl"):
        with pytest.raises(InputError, match=f"^mesh '{name}': is not a regular file"):
            mesh_file(tmp_path / name)


@pytest.mark.parametrize("scale", [0, -1.0, float("nan"), float("inf"), "mm"])
def test_bad_scale_is_refused(scale, write):
    with pytest.raises(InputError, match="scale = .*metres per unit"):
        mesh_file(write("unit.obj", TETRAHEDRON_OBJ), scale=scale)


def without_a_face(mesh):
    return trimesh.Trimesh(mesh.vertices, mesh.faces[1:], process=False)


def inside_out(mesh):
    return trimesh.Trimesh(mesh.vertices, mesh.faces[:, ::-1], process=False)


def one_face_turned(mesh):
    return trimesh.Trimesh(mesh.vertices, np.concatenate([mesh.faces[:1, ::-1], mesh.faces[1:]]), process=False)


@pytest.mark.parametrize(
    "mesh, words",
    [
        (without_a_face(box()), "not a closed surface, a triangle is missing at the edge"),
        (inside_out(box()), "solid 1 is inside out, volume = -1 m3"),
        (one_face_turned(box()), "turned opposite ways"),
        (trimesh.util.concatenate([box(), box(at=(1.0, 0.0, 0.0))]), "more than two triangles meet at the edge"),
        (trimesh.util.concatenate([box(), box(at=(0.5, 0.1, 0.1))]), "parts 0 and 1 overlap"),
        (trimesh.util.concatenate([box(3.0, 3.0, 3.0), inside_out(box())]), "solid 2 is inside out"),
        (trimesh.creation.torus(1.0, 0.3, 16, 8), "solid 1 is not convex, it fills .* of its hull"),
        (box(1.0, 1.0, 1e-13), "coplanar within 1e-12 of the size"),
    ],
    ids=["open", "inside out", "one face turned", "touching unnamed", "overlapping", "hollow", "torus", "flat"],
)
@pytest.mark.parametrize("ending", ["obj", "ply"])
def test_what_is_no_solid_of_convex_pieces_is_refused(mesh, words, ending, write):
    with pytest.raises(InputError, match=words):
        mesh_file(write(f"unit.{ending}", mesh))


def test_too_many_triangles_are_refused_from_the_header_alone(write, monkeypatch):
    monkeypatch.setattr("minibullet.shapes.mesh_text.MOST_TRIANGLES", 11)
    for name in ("unit.stl", "unit.obj", "unit.ply"):
        with pytest.raises(InputError, match="12 (triangles|of 'face') or more, at most 11 are read"):
            mesh_file(write(name, box()))


def test_too_large_a_file_is_refused_unread(write, monkeypatch):
    monkeypatch.setattr("minibullet.shapes.mesh_files.MOST_BYTES", 100)
    with pytest.raises(InputError, match="MB are read: simplify"):
        mesh_file(write("unit.stl", box()))

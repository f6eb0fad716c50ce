"""Mesh files: good ones give the exact solid, bad ones one clear message, and nothing else ever happens."""

import numpy as np
import pytest
import trimesh

from minibullet.errors import InputError
from minibullet.mesh_files import mesh_file
from minibullet.shapes import Compound, ConvexPiece

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


def test_nothing_but_the_file_itself_is_opened(write):
    path = write("unit.obj", "mtllib /nowhere/paint.mtl\nusemtl gold\n" + TETRAHEDRON_OBJ)
    assert mesh_file(path).volume == pytest.approx(1 / 6, rel=1e-14)


# --- bad files

def binary_stl(count, body=b""):
    return b"made by hand".ljust(80) + count.to_bytes(4, "little") + body


BAD_FILES = {
    "lying header": ("unit.stl", binary_stl(4294967280, b"0" * 50),
                     r"header announces 4294967280 triangles \(215 GB\), the file has 134 bytes; is it an ASCII STL\?"),
    "cut off": ("unit.stl", binary_stl(3, b"0" * 100), "header announces 3 triangles .234 bytes., the file has 184 bytes"),
    "no bytes": ("unit.stl", b"", "the file has 0 bytes"),
    "no triangles": ("unit.stl", binary_stl(0), "no triangles; the file is empty"),
    "empty solid": ("unit.stl", "solid a\nendsolid a\n", "no triangles; the file is empty"),
    "not a number, binary": ("unit.stl", binary_stl(1, b"\xff" * 50), "triangle 1: corner .* is not finite"),
    "not a number, ascii": ("unit.stl", ascii_stl(box()).replace("vertex 0.5", "vertex nan", 1),
                            r"line \d+: vertex 'nan .* is not finite"),
    "infinite": ("unit.obj", "v 0 0 0\nv 1 0 1e999\n", "line 2: vertex '1 0 1e999' is not finite"),
    "half a vertex": ("unit.obj", "v 0 0 0\nv 1 0\n", "line 2: vertex '1 0'; 3 numbers are needed"),
    "letters": ("unit.obj", "v 0 0 zero\n", "line 1: vertex '0 0 zero'; 3 numbers"),
    "two corners in a loop": ("unit.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
                              "line 6: facet with 2 vertices"),
    "ends within a facet": ("unit.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "ends within a facet"),
    "strange word": ("unit.stl", "solid a\nfacette normal 0 0 1\n", "line 2: 'facette' is no word"),
    "index too large": ("unit.obj", TETRAHEDRON_OBJ + "f 1 2 999999999\n",
                        "line 11: face uses vertex 999999999, but only 4 vertices are defined"),
    "index beyond any integer": ("unit.obj", TETRAHEDRON_OBJ + "f 1 2 " + "9" * 30 + "\n", "line 11: face uses vertex 9999"),
    "index zero": ("unit.obj", TETRAHEDRON_OBJ + "f 0 1 2\n", "line 11: face uses vertex 0"),
    "index before the beginning": ("unit.obj", TETRAHEDRON_OBJ + "f -5 1 2\n", "line 11: face uses vertex -5"),
    "index is a word": ("unit.obj", TETRAHEDRON_OBJ + "f one 1 2\n", "line 11: face corner 'one' is no vertex number"),
    "face of two": ("unit.obj", TETRAHEDRON_OBJ + "f 1 2\n", "line 11: face with 2 vertices"),
    "endless line": ("unit.obj", "v " + "0 " * 100_000, "line 1: longer than 100000 bytes"),
    "lying PLY": ("unit.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n",
                  "line 3: 'element vertex 99999999999', the file has 59 bytes"),
    "PLY without data": ("unit.ply", "ply\nformat ascii 1.0\nelement vertex 3\nend_header\n1", "not a readable PLY file"),
    "no PLY": ("unit.ply", "plaster", "no PLY header"),
    "no OFF": ("unit.off", "OFF 3 3 3\n1", "not a readable OFF file"),
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
    with pytest.raises(InputError, match="cannot be read"):
        mesh_file(tmp_path / "folder.stl")


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


@pytest.mark.parametrize("mesh, words", [
    (without_a_face(box()), "not a closed surface, a triangle is missing at the edge"),
    (inside_out(box()), "solid 1 is inside out, volume = -1 m3"),
    (one_face_turned(box()), "turned opposite ways"),
    (trimesh.util.concatenate([box(), box(at=(1.0, 0.0, 0.0))]), "more than two triangles meet at the edge"),
    (trimesh.util.concatenate([box(), box(at=(0.5, 0.1, 0.1))]), "parts 0 and 1 overlap"),
    (trimesh.util.concatenate([box(3.0, 3.0, 3.0), inside_out(box())]), "solid 2 is inside out"),
    (trimesh.creation.torus(1.0, 0.3, 16, 8), "solid 1 is not convex, it fills .* of its hull"),
    (box(1.0, 1.0, 1e-13), "coplanar within 1e-12 of the size"),
], ids=["open", "inside out", "one face turned", "touching unnamed", "overlapping", "hollow", "torus", "flat"])
@pytest.mark.parametrize("ending", ["obj", "ply"])
def test_what_is_no_solid_of_convex_pieces_is_refused(mesh, words, ending, write):
    with pytest.raises(InputError, match=words):
        mesh_file(write(f"unit.{ending}", mesh))


def test_too_many_triangles_are_refused_from_the_header_alone(write, monkeypatch):
    monkeypatch.setattr("minibullet.mesh_files.MOST_TRIANGLES", 11)
    for name in ("unit.stl", "unit.obj", "unit.ply"):
        with pytest.raises(InputError, match="triangles or more, at most 11 are read"):
            mesh_file(write(name, box()))


def test_too_large_a_file_is_refused_unread(write, monkeypatch):
    monkeypatch.setattr("minibullet.mesh_files.MOST_BYTES", 100)
    with pytest.raises(InputError, match="MB are read; simplify"):
        mesh_file(write("unit.stl", box()))


# --- fuzzing

def mutated(data, generator):
    """data with one to eight random accidents: bytes changed, cut, doubled, swapped, numbers replaced by nasty ones."""
    data = bytearray(data)
    nasty = [b"nan", b"-inf", b"1e999", b"1e-320", b"-0", b"999999999999999999999", b"", b"\xff\xff\xff\x7f", b"\0\0\xc0\x7f",
             b"f 1 2 3\n", b"v 0 0 0\n", b"endloop\n", b"solid\n", b"o x\n", b"\\\n",
             b"#", b"1/2/3", b"-1", b"0", b"\n", b"\r", b"1e150"]
    for _ in range(generator.integers(1, 9)):
        here = int(generator.integers(0, len(data) + 1))
        there = min(len(data), here + int(generator.integers(0, 40)))
        accident = generator.integers(0, 6)
        if accident == 0 and here < len(data):
            data[here] = generator.integers(0, 256)
        elif accident == 1:
            del data[here:there]
        elif accident == 2:
            data[here:here] = data[here:there]
        elif accident == 3:
            del data[here:]
        elif accident == 4:
            data[here:there] = nasty[generator.integers(0, len(nasty))]
        else:
            words = bytes(data).split(b" ")
            words[generator.integers(0, len(words))] = nasty[generator.integers(0, len(nasty))]
            data = bytearray(b" ".join(words))
    return bytes(data)


def fuzz(count, tmp_path, seed):
    """Read count mutated files; -> how many were refused. Anything but a solid or an InputError fails the test."""
    generator = np.random.default_rng(seed)
    ball = trimesh.creation.icosphere(0)
    meshes = [box(), ball, trimesh.util.concatenate([box(), box(at=(3.0, 0.0, 0.0))])]
    seeds = [(f"a.{kind}", mesh.export(file_type=kind)) for mesh in meshes for kind in ("stl", "stl_ascii", "obj", "ply", "off")]
    seeds = [(name.replace("stl_ascii", "stl"), data.encode() if isinstance(data, str) else data) for name, data in seeds]
    refused = 0
    for _ in range(count):
        name, data = seeds[generator.integers(0, len(seeds))]
        path = tmp_path / name
        path.write_bytes(mutated(data, generator))
        try:
            shape = mesh_file(path)
        except InputError as refusal:
            refused += 1
            assert str(refusal).startswith("mesh 'a.") and "\n" not in str(refusal)
        else:
            assert np.isfinite(shape.inertia).all() and shape.volume > 0
            assert np.linalg.eigvalsh(shape.inertia)[0] > 0
    return refused


@pytest.mark.filterwarnings("error")
def test_mutated_files_never_do_anything_but_load_or_be_refused(tmp_path):
    refused = fuzz(400, tmp_path, seed=1)
    assert 100 < refused < 400              # both ends are reached


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
def test_ten_thousand_mutated_files(tmp_path):
    assert 2_500 < fuzz(10_000, tmp_path, seed=2) < 10_000

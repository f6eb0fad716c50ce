"""Bottoms: height and normal agree with each other and with the solid that is put into the world."""

import numpy as np
import pytest

import minibullet as mb
from hlcs.placement.sea_bottom import Flat, Slope, Survey, parse_bottom
from minibullet import rotations
from minibullet.errors import InputError


def plane(x, y):
    return 0.1 * x - 0.05 * y - 12.0


def wave(x, y):
    return 0.1 * np.sin(x) * np.cos(0.7 * y) - 3.0


@pytest.fixture
def survey(tmp_path):
    """A function that writes a survey of a height function, points in any order, and reads it."""

    def write(function, x=(10.0, 11.0, 13.0), y=(100.0, 102.0, 103.0, 106.0)):
        points = [(a, b, function(a, b)) for a in x for b in y]
        order = np.random.default_rng(3).permutation(len(points))
        path = tmp_path / "bed.csv"
        path.write_text("# echo sounder\nname,x_m,y_m,z_m\n" + "".join("p,{},{},{}\n".format(*points[k]) for k in order))
        return Survey.from_csv(path)

    return write


def test_flat_and_slope():
    x, y = np.array([0.0, 1.0, 5.0]), np.array([0.0, 2.0, -5.0])
    np.testing.assert_array_equal(Flat().height(x, y), [0, 0, 0])
    np.testing.assert_allclose(Slope(0.04).height(x, y), [0, 0.08, -0.2])
    np.testing.assert_allclose(Slope(0.04).normal(1.0, 2.0), np.array([0, -0.04, 1]) / np.sqrt(1.0016))
    assert np.shape(Flat().normal(x, y)) == (3, 3)


@pytest.mark.parametrize("function", [plane, wave])
def test_survey_passes_through_its_points_about_its_middle(survey, function):
    bed = survey(function)
    assert (bed.x.tolist(), bed.y.tolist()) == ([-1.5, -0.5, 1.5], [-3.0, -1.0, 0.0, 3.0])
    x, y = np.meshgrid(bed.x, bed.y)
    np.testing.assert_allclose(bed.height(x, y), function(x + 11.5, y + 103.0), atol=1e-12)


def test_survey_of_a_plane_is_the_plane(survey, generator):
    bed = survey(plane)
    x, y = generator.uniform(-1.5, 1.5, 100), generator.uniform(-3, 3, 100)
    np.testing.assert_allclose(bed.height(x, y), plane(x + 11.5, y + 103.0), atol=1e-12)
    np.testing.assert_allclose(bed.normal(x, y), np.tile(np.array([-0.1, 0.05, 1]) / np.sqrt(1.0125), (100, 1)), atol=1e-12)


def test_normal_is_the_gradient_of_the_height(survey, generator):
    """Central differences within a triangle are exact; points within 1e-6 of an edge would mix two."""
    bed, step = survey(wave), 1e-7
    x, y = generator.uniform(-1.4, 1.4, 200), generator.uniform(-2.9, 2.9, 200)
    normal = bed.normal(x, y)
    slope_x = (bed.height(x + step, y) - bed.height(x - step, y)) / (2 * step)
    slope_y = (bed.height(x, y + step) - bed.height(x, y - step)) / (2 * step)
    np.testing.assert_allclose(-normal[:, 0] / normal[:, 2], slope_x, atol=1e-7)
    np.testing.assert_allclose(-normal[:, 1] / normal[:, 2], slope_y, atol=1e-7)


def test_prisms_are_the_solid_under_the_height(survey, generator):
    """Every point a little below the bed is in a prism, every point a little above in none; volumes add up without overlap."""
    bed = survey(wave)
    x, y = generator.uniform(-1.5, 1.5, 200), generator.uniform(-3, 3, 200)
    for lift, inside in ((-1e-6, True), (1e-6, False)):
        points = np.column_stack([x, y, bed.height(x, y) + lift])
        found = np.any([np.all(points @ p.normals.T <= p.offsets, axis=1) for p in bed.prisms], axis=0)
        assert np.all(found == inside)
    floor = min(p.vertices[:, 2].min() for p in bed.prisms)
    # Of two triangles on a diagonal, the corners on it count twice in the mean height.
    height = (bed.z[:-1, :-1] + bed.z[1:, 1:]) / 3 + (bed.z[:-1, 1:] + bed.z[1:, :-1]) / 6 - floor
    area = np.outer(np.diff(bed.y), np.diff(bed.x))
    assert sum(p.volume for p in bed.prisms) == pytest.approx(np.sum(height * area), rel=1e-12)


def test_bottoms_are_read_from_words(survey, tmp_path):
    survey(plane)
    assert parse_bottom("flat") == Flat()
    assert parse_bottom("slope:0.04") == parse_bottom("Slope: 4%") == Slope(0.04)
    assert parse_bottom("bed.csv", tmp_path).source == "bed.csv"
    assert parse_bottom(Slope(0.1)) == Slope(0.1)


@pytest.mark.parametrize(
    "text, words",
    [
        ("hilly", "bottom 'hilly': not understood; give flat, slope:0.04, or a survey"),
        ("slope:steep", "the slope is not a number"),
        ("slope:nan", "slope = nan"),
        ("slope:4", "slope = 4.0; must be a rise over run"),
        ("gone.csv", r"bottom 'gone.csv': cannot be read \(No such file"),
    ],
)
def test_what_is_no_bottom_is_refused_by_name(text, words, tmp_path):
    with pytest.raises(InputError, match=words):
        parse_bottom(text, tmp_path)


SQUARE = "x_m,y_m,z_m\n0,0,0\n1,0,0\n0,1,0\n1,1,0\n"


@pytest.mark.parametrize(
    "content, words",
    [
        ("", "is empty; the first row names the columns x_m,y_m,z_m"),
        ("x,y,z\n0,0,0\n", "row 1: column 'x_m' is missing in 'x,y,z'"),
        (SQUARE.replace("1,1,0", "1,1,deep"), "row 5, column z_m: 'deep' is not a number"),
        (SQUARE.replace("1,1,0", "1,nan,0"), "row 5, column y_m: 'nan' is not finite"),
        (SQUARE.replace("1,1,0", "1,1"), "row 5: 2 cells for 3 columns"),
        (SQUARE + "1,1,3\n", "row 6: the point x_m = 1, y_m = 1 stands already in row 5"),
        (
            SQUARE + "2,1,0\n",
            r"5 points, but 3 different x_m times 2 different y_m are 6; the first one missing is x_m = 2, y_m = 0",
        ),
        ("x_m,y_m,z_m\n0,0,0\n1,0,0\n2,0,0\n3,0,0\n", "4 different x_m and 1 different y_m"),
        ("x_m,y_m,z_m\n0,0,0\n", "1 points; a survey has 4 to"),
        (b"\xff\xfe\x00", "not text in UTF-8"),
    ],
)
def test_bad_surveys_are_refused_by_row(content, words, tmp_path):
    path = tmp_path / "bed.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError, match=words):
        Survey.from_csv(path)


def test_outside_the_survey_is_refused(survey):
    with pytest.raises(InputError, match=r"x = 2 m, y = 0 m lies outside the survey, 3 m x 6 m about its middle"):
        survey(plane).height([0.0, 2.0], [0.0, 0.0])


@pytest.mark.parametrize("kind", ["flat", "slope", "survey"])
def test_a_box_comes_to_lie_on_the_bottom(kind, survey):
    """Dropped from a millimetre it stays half its height above; on a plane bed it does not feel the edges between prisms."""
    bottom = {"flat": Flat(), "slope": Slope(0.04), "survey": survey(lambda x, y: 0.04 * y)}[kind]
    world = mb.World(effects=[mb.Gravity(9.81)], settings=mb.Settings(friction=0.6))
    bottom.add_to(world)
    normal = bottom.normal(0.3, 0.2)
    at = np.array([0.3, 0.2, bottom.height(0.3, 0.2)]) + 0.101 * normal
    box = world.add(mb.Box(0.2, 0.2, 0.2), density=1000.0, position=at, orientation=rotations.between([0, 0, 1], normal))
    world.run(0.5)
    gap = (box.position - [0.3, 0.2, bottom.height(0.3, 0.2)]) @ normal
    assert gap == pytest.approx(0.1, abs=1e-5)
    assert np.linalg.norm(box.velocity) < 1e-6

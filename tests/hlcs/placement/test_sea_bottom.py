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
        ("hilly", "bottom 'hilly': not understood; give flat, slope:0.04, mound:1.5,8,0.5,20, or a survey"),
        ("slope:steep", "the slope is not a number"),
        ("slope:nan", "slope = nan"),
        ("slope:4", "slope = 4.0; must be a rise over run"),
        ("mound:1,2", "a mound has four numbers, its height, crest width, grade of the sides and length"),
        ("mound:1,8,2,20", "the grade of the mound is 2; it must be above 0 and at most 1"),
        ("mound:1,8,0.5,-1", "the length of the mound is -1; it must be finite and above 0"),
        ("mound:1,8,0.5,1e9", "the length of the mound is 1e\\+09"),
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
        ("x_m,y_m,z_m\n0,0,0\n1,0,0\n2,0,0\n3,0,0\n", "'bed.csv': the 4 points lie on a line, or nearly so"),
        ("x_m,y_m,z_m\n0,0,0\n1,1,0\n2,2,0\n3,3.01,0\n", "the 4 points lie on a line, or nearly so"),
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


@pytest.fixture
def scattered(tmp_path, generator):
    """A function that writes a survey of n points scattered over 20 m x 16 m about (1000, 2000), and reads it; keep: which of
    them (of their coordinates) were surveyed."""

    def write(function, n=900, keep=lambda x, y: x == x):
        x, y = generator.uniform(990, 1010, n), generator.uniform(1992, 2008, n)
        there = keep(x, y)
        rows = [f"{a!r},{b!r},{c!r}" for a, b, c in zip(*(v[there].tolist() for v in (x, y, function(x, y))), strict=True)]
        path = tmp_path / "bed.csv"
        path.write_text("\n".join(["x_m,y_m,z_m", *rows]))
        return Survey.from_csv(path)

    return write


def test_scattered_points_of_a_plane_are_the_plane(scattered, generator):
    """Linear interpolation is exact on a plane; 1e-9 is rounding of coordinates of 2000 m. The rim of the random points lies
    within half a metre of their rectangle, whose middle moves by as much."""
    bed = scattered(plane)
    middle = 0.5 * (bed.points[:, :2].min(axis=0) + bed.points[:, :2].max(axis=0))
    x, y = generator.uniform(-8.5, 8.5, 200), generator.uniform(-6.5, 6.5, 200)
    np.testing.assert_allclose(bed.height(x, y), plane(x + middle[0], y + middle[1]), atol=1e-9)
    assert max(bed.misfit) < 1e-9


def test_scattered_points_of_a_wave_are_it_within_the_bound_of_linear_interpolation(scattered, generator):
    """Twice linear, on triangles and on the grid: the error of each is at most step^2 / 2 times the largest second derivative,
    0.1 of the wave, on triangles and cells no wider than twice the mean distance of the points, 0.6 m."""
    bed = scattered(wave)
    middle = 0.5 * (bed.points[:, :2].min(axis=0) + bed.points[:, :2].max(axis=0))
    x, y = generator.uniform(-8.5, 8.5, 200), generator.uniform(-6.5, 6.5, 200)
    error = bed.height(x, y) - wave(x + middle[0], y + middle[1])
    assert np.abs(error).max() < 2 * 0.5 * 0.1 * 1.2**2 and np.sqrt(np.mean(error**2)) < 0.02
    assert 0.0 < bed.misfit[0] < bed.misfit[1] < 0.1


def test_what_scattered_points_do_not_cover_is_refused_and_nothing_stands_there(scattered):
    """Points in the left half and in a strip on the right: the hole between them, 6 m wide, is farther than 4 mean distances."""
    bed = scattered(plane, keep=lambda x, y: (x < 1000) | (x > 1006))
    with pytest.raises(InputError, match=r"'bed.csv': no point was surveyed near x = 3 m, y = 0 m"):
        bed.height([-5.0, 3.0], [0.0, 0.0])
    assert np.isfinite(bed.extended_height(3.0, 0.0))
    assert not any(p.vertices[:, 0].min() < 3.0 < p.vertices[:, 0].max() and abs(p.centre_of_mass[1]) < 2 for p in bed.prisms)
    assert len(bed.prisms) == 2 * bed.covered.sum()


def test_a_corner_without_points_is_outside_their_outline(scattered):
    bed = scattered(plane, keep=lambda x, y: (x - 990) + (y - 1992) > 12)
    with pytest.raises(InputError, match="no point was surveyed near x = -8 m, y = -6 m"):
        bed.height(-8.0, -6.0)


def test_a_scattered_bed_reads_back_to_the_same(scattered, tmp_path):
    bed = scattered(wave, n=60)
    (tmp_path / "again.csv").write_text(bed.csv_text())
    again = Survey.from_csv(tmp_path / "again.csv")
    for name in ("x", "y", "z", "covered", "points"):
        np.testing.assert_array_equal(getattr(again, name), getattr(bed, name))


def test_a_mound_has_its_height_its_slopes_and_level_ground(tmp_path):
    bed = parse_bottom("mound:1.5,8,0.5,20")
    y = np.array([-10.0, -7.0, -5.5, -4.0, 0.0, 4.0, 6.0, 7.0, 14.0])
    np.testing.assert_allclose(bed.height(np.full(9, 3.3), y), [0.0, 0.0, 0.75, 1.5, 1.5, 1.5, 0.5, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(bed.normal(1.0, 5.0), np.array([0.0, 0.5, 1.0]) / np.sqrt(1.25), atol=1e-12)
    (tmp_path / "bed.csv").write_text(bed.csv_text())
    np.testing.assert_array_equal(Survey.from_csv(tmp_path / "bed.csv").z, bed.z)


def test_units_on_the_rim_of_a_survey_are_refused_before_they_are_placed(survey):
    """Three units of 1.07 m side by side need 2 x 1.58 Dn and half a Dn on either side, 4.4 m: this survey is 3 m wide."""
    from hlcs import PlacementTest

    with pytest.raises(InputError, match=r"bottom 'bed.csv': the point x = -2\.\d+ m, .* lies outside the survey"):
        PlacementTest(layers=1, rows=3, columns=3, bottom=survey(plane)).run()

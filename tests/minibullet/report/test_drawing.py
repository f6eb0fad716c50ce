"""Pictures show what is there: the right colour in the right place, nearer things in front; files whole and self-contained."""

import json
import re

import numpy as np
import pytest
import trimesh

import minibullet as mb
from minibullet.errors import InputError
from minibullet.report import drawing, rendering
from minibullet.shapes.primitives import Box, Capsule, Compound, ConvexPiece, Sphere

HERE, UPRIGHT = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def solids(*rows):
    return drawing._solids(drawing._items(rows, None))


def is_colour(pixel, colour):
    """Whether the pixel has only the channels of the colour: shading changes brightness alone."""
    return pixel[:3].max() > 0.2 and np.all(pixel[:3][np.array(colour) == 0] < 1e-9)


def test_nearer_things_hide_farther_ones_whatever_the_order():
    """A red box before a blue one, seen along -y from the front; the middle of the picture is red, its upper part blue."""
    rows = [(Box(1.0, 1.0, 1.0), (0.0, -3.0, 0.0), UPRIGHT, RED), (Box(1.0, 1.0, 3.0), (0.0, 3.0, 0.0), UPRIGHT, BLUE)]
    for order in (rows, rows[::-1]):
        image = rendering.render(solids(*order), 200, 200, azimuth=-90.0, elevation=0.0)
        assert is_colour(image[100, 100], RED)
        assert is_colour(image[25, 100], BLUE)


def test_picture_is_seen_the_right_way_round():
    """From azimuth -90 degrees (the -y side), +x is to the right; from above, z comes nearer."""
    pair = solids((Box(1.0, 1.0, 1.0), (2.0, 0.0, 0.0), UPRIGHT, RED), (Box(1.0, 1.0, 1.0), (-2.0, 0.0, 0.0), UPRIGHT, BLUE))
    image = rendering.render(pair, 300, 100, azimuth=-90.0, elevation=20.0)
    assert is_colour(image[50, 250], RED)
    assert is_colour(image[50, 50], BLUE)


def test_a_square_covers_its_area():
    """A box seen face on fills 94 % of the image's height and as much width; transparent outside."""
    image = rendering.render(solids((Box(1.0, 1.0, 1.0), HERE, UPRIGHT, RED)), 200, 200, azimuth=0.0, elevation=0.0)
    assert image[..., 3].mean() == pytest.approx(0.94**2, abs=0.01)
    assert set(np.unique(image[..., 3])) <= {0.0, 0.25, 0.5, 0.75, 1.0}


def test_a_scene_scaled_by_a_power_of_two_is_the_same_picture():
    """Drawing has no length scale either."""

    def picture(s):
        box, ball = (Box(s, 2 * s, 3 * s), HERE, UPRIGHT, RED), (Sphere(s), (0.0, 4 * s, 0.0), UPRIGHT, BLUE)
        return rendering.render(solids(box, ball), 120, 80)

    np.testing.assert_allclose(picture(1.0), picture(2.0**-10), atol=1e-12)


@pytest.mark.parametrize(
    "piece",
    [Sphere(0.5).pieces[0], Capsule(0.3, 1.0).pieces[0], ConvexPiece([[1.0, 2.0, 3.0], [2.0, 4.0, 1.0]], radius=0.5)],
    ids=["ball", "capsule", "askew"],
)
def test_round_pieces_are_drawn_on_their_surface(piece):
    """All corners lie at the radius from the core; 32 faces round lose (2 pi/32)^2/6 or so of each cross section."""
    vertices, _ = drawing._round_part(piece)
    a, b = piece.vertices[0], piece.vertices[-1]
    along = np.clip((vertices - a) @ (b - a) / max((b - a) @ (b - a), 1e-300), 0, 1)
    np.testing.assert_allclose(np.linalg.norm(vertices - a - along[:, None] * (b - a), axis=1), piece.radius, rtol=1e-12)
    assert 0.98 < ConvexPiece(vertices).volume / piece.volume < 1.0


@pytest.fixture
def world():
    world = mb.World(effects=[mb.Gravity(9.81)])
    world.add_plane()
    for k in range(3):
        world.add(Box(1.0, 1.0, 1.0), density=1000.0, position=(2.0 * k, 0.0, 0.6))
    world.add(
        Compound((Box(1.0, 1.0, 1.0), ConvexPiece(Box(1.0, 1.0, 1.0).pieces[0].vertices + (1.0, 0.0, 0.0)))),
        density=1000.0,
        position=(0.0, 3.0, 0.6),
        name="</script>",
    )
    return world


def test_page_is_one_file_that_asks_for_nothing(world, tmp_path):
    drawing.write_page(tmp_path / "scene.html", world, title="</script> & more", colours=[0, 1, 2, "tomato"])
    text = (tmp_path / "scene.html").read_text()
    assert not re.search(r"(src|href)\s*=|https?:|import\s|fetch\(|url\(", text)
    assert text.count("</script>") == 1  # the title does not end the script
    data = json.loads(re.search(r"const scene = (.*);\n", text).group(1))
    assert data["title"] == "</script> & more"
    assert len(data["bodies"]) == 5  # four bodies and the floor
    assert len(data["shapes"]) == 3  # three equal boxes are stored once
    assert [path.name for path in tmp_path.iterdir()] == ["scene.html"]


def test_page_keeps_its_digits_for_small_units():
    """A laboratory unit of 4 cm is drawn as sharply as one of 4 m."""
    large, small = (
        json.loads(
            re.search(r"const scene = (.*);\n", drawing.page([(Box(s, 2 * s, 3 * s), (s / 3, 0, 0), UPRIGHT, 0)])).group(1)
        )
        for s in (1.0, 2.0**-6)
    )
    assert large == small


def test_glb_has_every_body_in_place_with_y_up(world, tmp_path):
    drawing.write_glb(tmp_path / "scene.glb", world)
    scene = trimesh.load(tmp_path / "scene.glb", force="scene")
    assert len(scene.graph.nodes_geometry) == 5
    assert len(scene.geometry) == 3
    # World (x, y, z) becomes (x, z, -y): the bodies reach up to 1.1 m, the floor is at 0, the compound at y = 3 is at z = -3.
    assert scene.bounds[:, 1] == pytest.approx([0.0, 1.1], abs=1e-6)
    transform = scene.graph.get("body 3")[0]
    np.testing.assert_allclose(transform[:3, 3], [0.0, 0.6, -3.0], atol=1e-6)


def test_still_picture_into_a_file_and_onto_axes(world, tmp_path):
    ax = drawing.draw_scene(world, tmp_path / "scene.png", colours=[0, 1, 2, 3], width=300, height=200)
    assert (tmp_path / "scene.png").read_bytes().startswith(b"\x89PNG")
    assert [path.name for path in tmp_path.iterdir()] == ["scene.png"]
    assert drawing.draw_scene(world, ax=ax, width=60, height=40) is ax


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda world: drawing.page([]), "nothing to draw"),
        (lambda world: drawing.page(world, colours=[0]), "1 colours for 4 bodies"),
        (lambda world: drawing.page([(Sphere(1.0), HERE, UPRIGHT, "reddish")]), "colour = 'reddish'"),
    ],
)
def test_what_cannot_be_drawn_is_refused(call, words, world):
    with pytest.raises(InputError, match=words):
        call(world)


@pytest.mark.parametrize(("azimuth", "elevation", "axes"), [(-90, 0, (0, 2)), (0, 0, (1, 2)), (-90, 90, (0, 1))])
def test_lengths_can_be_measured_in_a_parallel_view(azimuth, elevation, axes):
    """A near and a far cube are drawn as large, and where they stand: the middle of each colour is its place to half a pixel,
    here 0.01 m, and a thousandth of their distance to the middle for what perspective is left."""
    box = mb.Box(1.0, 1.0, 1.0)
    places = np.array([(0.0, -2.0, 4.0), (3.0, 5.0, 0.0)])
    scene = [(box, place, (1, 0, 0, 0), colour) for place, colour in zip(places, ("#ff0000", "#0000ff"), strict=True)]
    image, (left, right, bottom, top) = drawing.parallel_view(scene, azimuth, elevation, width=400)
    assert (right - left) / image.shape[1] == pytest.approx((top - bottom) / image.shape[0], rel=0.01)
    for place, channel in zip(places, (0, 2), strict=True):
        mask = (image[..., 3] > 0.5) & (image[..., channel] > 2 * image[..., 2 - channel])
        row, column = (0.5 * (where.min() + where.max() + 1) for where in np.nonzero(mask))
        assert left + column * (right - left) / image.shape[1] == pytest.approx(place[axes[0]], abs=0.02)
        assert top - row * (top - bottom) / image.shape[0] == pytest.approx(place[axes[1]], abs=0.02)
        width = (np.ptp(np.nonzero(mask)[1]) + 1) * (right - left) / image.shape[1]
        assert width == pytest.approx(1.0, abs=0.03)


def test_a_page_of_things_that_move_holds_every_frame_in_units_of_the_smallest_body():
    """Two boxes, the second of which sinks by half a metre: the smallest body has its farthest corner at 0.5 m."""
    box = mb.Box(1.0, 1.0, 1.0)
    scene = [(box, (0, 0, 0.5), (1, 0, 0, 0), 0), (box, (0, 0, 2.5), (1, 0, 0, 0), 1)]
    poses = np.array([[[0, 0, z, 1, 0, 0, 0]] for z in (2.5, 2.25, 2.0)], dtype=float)
    text = drawing.page(scene, motion=drawing.Motion(1, np.array([0.0, 0.1, 0.2]), poses))
    motion = json.loads(re.search(r"const scene = (\{.*\});", text)[1])["motion"]
    assert (motion["first"], motion["times"]) == (1, [0.0, 0.1, 0.2])
    assert [frame[0][2] for frame in motion["poses"]] == [5.0, 4.5, 4.0] and motion["poses"][0][0][3:] == [1, 0, 0, 0]
    assert '"motion"' not in drawing.page(scene)


def page_data(text):
    return json.loads(re.search(r"const scene = (\{.*\});", text)[1])


def test_a_page_colours_things_by_values_on_a_scale_that_grows_lighter():
    """A hundred values 0 .. 99: the scale ends at their 98 % quantile, 0.98 x 99, so that one far value leaves the others apart.

    Readers who see no colours see lightness: weighed as in sRGB it grows from step to step.
    """
    boxes = [(Box(1.0, 1.0, 1.0), (2.0 * k, 0.0, 0.0), UPRIGHT, 0) for k in range(100)]
    values = np.arange(100.0)
    data = page_data(drawing.page(boxes, shades=[drawing.Shades("distance", "m", values)]))
    (shade,) = data["shades"]
    assert (shade["name"], shade["unit"], shade["low"], shade["beyond"]) == ("distance", "m", 0.0, True)
    assert shade["high"] == pytest.approx(0.98 * 99) and shade["values"] == values.tolist()
    lightness = np.array(data["scale"]) @ (0.2126, 0.7152, 0.0722)
    assert np.all(np.diff(lightness) > 0.0) and lightness[-1] - lightness[0] > 150


def test_a_page_has_no_button_for_values_that_nothing_has_and_says_which_are_missing():
    box = [(Box(1.0, 1.0, 1.0), HERE, UPRIGHT, 0), (Sphere(1.0), (3.0, 0.0, 0.0), UPRIGHT, 1)]
    assert "shades" not in page_data(drawing.page(box, shades=[drawing.Shades("distance", "m", np.array([np.nan, np.nan]))]))
    (shade,) = page_data(drawing.page(box, shades=[drawing.Shades("distance", "m", np.array([np.nan, 0.0]))]))["shades"]
    assert shade["values"] == [None, 0.0] and shade["high"] > shade["low"] and not shade["beyond"]

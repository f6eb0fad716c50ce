"""A world shows itself in a line, a table, a picture and a film; showing changes nothing, a film is the run itself."""

import json
import re

import numpy as np
import pytest

import minibullet as mb


def falling():
    world = mb.World([mb.Gravity(9.81)], mb.Settings(time_step=0.01))
    world.add_plane()
    world.add(mb.Box(1.0, 1.0, 1.0), density=1000.0, position=(0.0, 0.0, 2.0), name="<box>")
    return world


def test_a_world_tells_its_time_bodies_and_effects_and_its_last_step():
    world = falling()
    assert "t = 0 s, 0 steps; 1 body; effects: Gravity(" in repr(world)
    world.settle(max_time=5.0)
    assert re.search(r"last step: 4 contacts, residual \S+, penetration \S+ m", repr(world))


def test_the_table_of_a_notebook_has_the_first_twelve_bodies_and_no_markup_of_a_name():
    world = falling()
    for k in range(14):
        world.add(mb.Sphere(0.1), density=1000.0, position=(3.0 + k, 0.0, 1.0))
    shown = world._repr_html_()
    assert "&lt;box&gt;" in shown and "<box>" not in shown and shown.count("<tr>") == 13 and "and 3 more" in shown


def test_a_film_is_the_run_itself():
    """A fall of 0.2 s: every frame is where a world that was not watched stands after as many steps, bit for bit."""
    watched, alone = falling(), falling()
    film = watched.record(0.2, frames_per_second=25.0)
    assert film.times == pytest.approx([0.0, 0.04, 0.08, 0.12, 0.16, 0.2]) and film.poses.shape == (6, 1, 7)
    for frame in film.poses[1:]:
        alone.step(4)
        np.testing.assert_array_equal(frame[0, :3], alone.bodies[0].position)


def test_a_film_is_a_page_with_a_slider_a_gif_and_an_animation(tmp_path):
    film = falling().record(0.12)
    film.write_page(tmp_path / "film.html", title="a box")
    text = (tmp_path / "film.html").read_text()
    content = json.loads(re.search(r"const scene = (\{.+\});", text).group(1))
    assert len(content["motion"]["times"]) == 4 and "http" not in text and "srcdoc" in film._repr_html_()
    film.write_gif(tmp_path / "film.gif")
    assert (tmp_path / "film.gif").read_bytes().startswith(b"GIF89a")
    assert "<img" in film.animation().to_jshtml()


def test_a_world_is_drawn_onto_axes():
    assert falling().draw(width=120, height=80).images


@pytest.mark.parametrize("given", [{"duration": 0.0}, {"duration": np.nan}, {"duration": 1.0, "frames_per_second": -1.0}])
def test_a_film_without_a_length_is_refused(given):
    with pytest.raises(mb.InputError, match="record: .+ must be finite and above zero"):
        falling().record(**given)


def test_a_film_of_too_many_frames_is_refused():
    with pytest.raises(mb.InputError, match="at most 2000"):
        falling().record(100.0, frames_per_second=100.0)

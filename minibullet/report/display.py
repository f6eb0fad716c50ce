"""How a world shows itself: a line, a table in a notebook, a picture, and a film of what it does next."""

from dataclasses import dataclass
from html import escape

import numpy as np

from minibullet.errors import InputError, is_number, shown_value
from minibullet.values import Named, table

MOST_ROWS = 12  # bodies that the table in a notebook lists
MOST_FRAMES = 2000  # of a film: each keeps the pose of every body
HEIGHT = "26em"  # of a film in a notebook


def drawing():
    """The module that draws, loaded when something is drawn: no run needs it, and none is another run because it changed."""
    from minibullet.report import drawing

    return drawing


class Display(Named):
    """What a World shows of itself; nothing of it changes the world, but `record`, which lets time pass."""

    def __repr__(self):
        count = len(self.bodies)
        words = [f"{count} {'body' if count == 1 else 'bodies'}", f"effects: {', '.join(map(repr, self.effects)) or 'none'}"]
        if self.last_step is not None:
            last = self.last_step
            said = f"{len(last.contacts.gap)} contacts, residual {last.residual:.1e}, penetration {last.penetration:.1e} m"
            words.append(f"last step: {said}")
        return f"<World at t = {self.time:.6g} s, {self.steps} steps; {'; '.join(words)}>"

    def _repr_html_(self):
        rows = [
            (
                body.name,
                type(body.shape).__name__,
                np.array2string(body.position, precision=4),
                "fixed" if body.fixed else f"{np.linalg.norm(body.velocity):.4g}",
            )
            for body in self.bodies[:MOST_ROWS]
        ]
        more = len(self.bodies) - MOST_ROWS
        rest = f"<p>and {more} more</p>" if more > 0 else ""
        return table(repr(self), ("body", "shape", "position [m]", "speed [m/s]"), rows) + rest

    def draw(self, path=None, ax=None, **options):
        """A picture of the world as it stands: into a PNG file, onto matplotlib Axes, or both; returns the Axes.

        path: of the PNG file; ax: Axes to draw on, new ones where left out; options: of `minibullet.report.drawing.draw_scene`,
        such as colours, azimuth and elevation [degrees].
        """
        return drawing().draw_scene(self, path, ax, **options)

    def record(self, duration, frames_per_second=25.0, colours=None):
        """Run for a duration and keep what is seen: a `Film`, which shows itself in a notebook with a slider for the time.

        duration: of the run [s]; frames_per_second: of world time [1/s]; colours: one for each body, in the order they were
        added. InputError for a duration or a rate that is not finite and above zero, and for more than 2,000 frames.
        """
        for name, value in (("duration", duration), ("frames_per_second", frames_per_second)):
            if not (is_number(value) and 0.0 < value < np.inf):
                raise InputError(f"record: {name} = {shown_value(value)}; it must be finite and above zero")
        steps = max(1, round(duration / self.settings.time_step))
        stride = max(1, round(1.0 / (frames_per_second * self.settings.time_step)))
        if steps / stride > MOST_FRAMES:
            raise InputError(f"record: {steps // stride} frames; at most {MOST_FRAMES}: give fewer frames_per_second")
        rows = drawing().rows_of_world(self, colours)
        times, poses = [self.time], [_poses(self)]
        for first in range(0, steps, stride):
            self.step(min(stride, steps - first))
            times.append(self.time)
            poses.append(_poses(self))
        return Film(tuple(rows), np.array(times), np.array(poses))


def _poses(world):
    """Positions and orientations of all bodies (n, 7)."""
    return [[*body.position, *body.orientation] for body in world.bodies]


@dataclass(frozen=True, eq=False, repr=False)
class Film:
    """What bodies did: shown in a notebook with a slider for the time, as a GIF, as a page that opens offline, as an animation.

    rows: (shape, position, orientation, colour) of all that is drawn at the start, bodies first; times: of the frames (f,) [s];
    poses: of the bodies (f, n, 7), positions [m] and orientations (w, x, y, z).
    """

    rows: tuple
    times: np.ndarray
    poses: np.ndarray

    def __repr__(self):
        frames, count = self.poses.shape[:2]
        bodies = "1 body" if count == 1 else f"{count} bodies"
        return f"<Film of {bodies}: {frames} frames from {self.times[0]:.6g} to {self.times[-1]:.6g} s>"

    def plot(self, ax=None):
        """Draw the height of every body's centre over time. ax: Axes to draw on, new ones where left out; returns the Axes."""
        from minibullet.report import curves

        return curves.height_axes(self, ax)

    def page(self, title="minibullet"):
        """The text of one HTML file: drag to turn, slide to move in time; title: what stands above it."""
        return drawing().page(self.rows, title=title, motion=drawing().Motion(0, self.times - self.times[0], self.poses))

    def write_page(self, path, title="minibullet"):
        """Write `page` to a file; path: of the file; title: what stands above it."""
        drawing().write_bytes(path, self.page(title).encode())

    def write_gif(self, path, azimuth=-60.0, elevation=28.0):
        """Write an endless GIF, as fast as the world was, seen from azimuth, elevation; path: of the file; azimuth, elevation: of
        the eye [degrees]."""
        images = self._images(azimuth, elevation)
        drawing().write_bytes(path, drawing().gif_bytes(images, [*np.diff(self.times), 1.0]))

    def animation(self, azimuth=-60.0, elevation=28.0):
        """A matplotlib animation, for `HTML(film.animation().to_jshtml())`; azimuth, elevation: of the eye [degrees]."""
        return drawing().animation(self._images(azimuth, elevation), float(np.diff(self.times).mean()))

    def _images(self, azimuth, elevation):
        still = self.rows[self.poses.shape[1] :]
        scenes = [
            [*((row[0], pose[:3], pose[3:], row[3]) for row, pose in zip(self.rows, frame, strict=False)), *still]
            for frame in self.poses
        ]
        return drawing().moving_views(scenes, azimuth=azimuth, elevation=elevation)

    def _repr_html_(self):
        frame = f'style="width: 100%; height: {HEIGHT}; border: 1px solid #ddd"'
        return f'<iframe title="what the bodies did" {frame} srcdoc="{escape(self.page())}"></iframe>'

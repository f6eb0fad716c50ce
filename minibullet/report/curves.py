"""Curves and bars of what a step and a run tell. Each takes `ax=None` and returns the Axes; nothing is shown or kept open."""

import numpy as np

INK, FIRST, SECOND, LIGHT = "#222222", "#1c5a85", "#e07b1a", "#b5b5b5"  # of unlike lightness: they differ in print as well
SIZE = (5.0, 3.4)  # of one panel [inch]
LEAST = 1e-16  # a residual of exactly zero on a logarithmic scale [-]


def new_axes(rows=1, size=SIZE):
    """Axes of a new figure, one above the other, array (rows,)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(size[0], rows * size[1]), layout="constrained")
    FigureCanvasAgg(figure)
    return np.atleast_1d(figure.subplots(rows, 1, sharex=rows > 1))


def _named(ax, title, x, y):
    ax.set_title(title, loc="left", fontsize=11, color=INK)
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def work_axes(step, ax=None):
    """What gave and took kinetic energy in a step: one bar a line of its books [J]; returns the Axes."""
    ax = new_axes()[0] if ax is None else ax
    names, values = [name.replace("_", " ") for name in step.work], list(step.work.values())
    ax.barh(names, values, color=[FIRST if value >= 0.0 else SECOND for value in values])
    ax.axvline(0.0, color=INK, linewidth=0.75)
    ax.invert_yaxis()
    return _named(ax, f"What changed the kinetic energy in step {step.step}", "work [J]", "")


def friction_axes(table, ax=None):
    """Friction force over normal force of every contact, and Coulomb's limit of each [N]; returns the Axes.

    table: the contacts as a frame. A contact on its limit slides, one below it sticks.
    """
    ax = new_axes()[0] if ax is None else ax
    normal, limit = table["normal_force"], table["friction"] * table["normal_force"]
    ax.plot(normal, limit, "_", color=SECOND, markersize=12, markeredgewidth=2, label="limit: friction x normal force")
    ax.plot(normal, table["friction_force"], "o", color=FIRST, markersize=5, label="friction force")
    ax.set_xlim(left=0.0)
    ax.set_ylim(bottom=0.0)
    if len(table):
        ax.legend(frameon=False, fontsize=9)
    return _named(ax, "A contact on its limit slides, one below it sticks", "normal force [N]", "friction force [N]")


def run_axes(journal, ax=None):
    """Energies [J] and, below, the residual beside the tolerance [-] of every step over time [s]; returns the two Axes.

    ax: two Axes.
    """
    upper, lower = axes = new_axes(2) if ax is None else np.ravel(ax)
    times = [row["t"] for row in journal.rows]
    kinetic, potential = (np.array([row[name] for row in journal.rows]) for name in ("E_kin", "E_pot"))
    upper.plot(times, kinetic, color=FIRST, label="kinetic")
    upper.plot(times, potential, "--", color=SECOND, label="potential")
    upper.plot(times, kinetic + potential, ":", color=INK, label="sum")
    upper.legend(frameon=False, fontsize=9)
    _named(upper, "Energy", "", "energy [J]")
    lower.semilogy(times, [max(row["residual"], LEAST) for row in journal.rows], ".", color=FIRST, markersize=4)
    if journal.tolerance is not None:
        lower.axhline(journal.tolerance, color=SECOND, linestyle="--", linewidth=1, label="tolerance")
        lower.legend(frameon=False, fontsize=9)
    _named(lower, "How exactly each step was solved", "time [s]", "relative residual [-], zero as 1e-16")
    return axes


def height_axes(film, ax=None):
    """Height of every body's centre over time; returns the Axes."""
    ax = new_axes()[0] if ax is None else ax
    ax.plot(film.times, film.poses[:, :, 2], color=FIRST, linewidth=1, alpha=max(0.15, film.poses.shape[1] ** -0.5))
    return _named(ax, "Where the bodies are", "time [s]", "height of the centre [m]")

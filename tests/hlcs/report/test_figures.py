"""The data of the pictures: what is joined by lines, at which scale, and what stands at which place."""

from dataclasses import replace

import numpy as np
import pytest
from planted import AMBIGUOUS, COMPLETE, EFFECT, NOISE, UNEXPLAINED, number, pictures, table

from hlcs.rendering import Pictures
from hlcs.report import diagnosis_figures as figures
from minibullet.errors import InputError

LEFT = np.random.default_rng(1).standard_normal(50) * NOISE
RECORDED = replace(EFFECT, pictures=pictures(table(LEFT + np.linspace(0, 0.3, 50)), table(LEFT)))


def layers(sets=3, count=5):
    """A table of the layers of some sets, as the kind of layers makes it, and its Pictures."""
    rows = sets * count
    layer = np.tile(np.arange(1, count + 1), sets)
    measured = 1.3 - 0.08 * np.log(layer)

    def of(shift):
        residual = np.full(rows, shift)
        known = {"trial": np.repeat(np.arange(sets), count), "channel": np.zeros(rows, int), "layer": layer}
        known |= {"input": np.arange(1.0, rows + 1), "measured": measured, "model": measured - residual}
        return known | {"residual": residual, "sigmas": residual / 0.01}

    return Pictures(of(-0.1), of(0.005), ("RPG", "TPG", "slope"), "input", "row: the layers, set after set")


LAYERED = replace(EFFECT, kind="layers", pictures=layers())


def drawn(axes):
    """The lines of an Axes that join or mark more than one point: [(x, y)]."""
    return [line.get_xydata() for line in axes.lines if len(line.get_xdata()) > 2]


def test_no_line_joins_the_layers_of_one_grid_with_those_of_another():
    """Measured, before and after: a line of five points for each of three grids, and none is longer."""
    (axes,) = figures.fit_panel(LAYERED)
    lines = drawn(axes)
    assert len(lines) == 9 and all(len(line) == 5 for line in lines)
    assert all(np.ptp((line[:, 0] - 1) // 5) == 0 for line in lines)  # within one set
    for axes in figures.residual_panels(LAYERED, "input"):
        joined = [line for line in axes.lines if line.get_linestyle() == "-" and len(line.get_xdata()) > 2]
        assert [len(line.get_xdata()) for line in joined] == [5, 5, 5]


def test_rows_of_a_table_are_marks_without_a_line():
    rows = table(np.linspace(-1, 1, 12) * NOISE, trials=1)
    rows = {name: values for name, values in rows.items() if name not in ("time", "height", "speed")} | {"input": np.arange(12.0)}
    found = replace(EFFECT, pictures=Pictures(rows, rows, ("all",), "input", "height_m"))
    (axes,) = figures.fit_panel(found)
    assert len(axes.lines) == 3 and all(line.get_linestyle() == "None" for line in axes.lines)
    assert axes.get_xlabel() == "height [m]"


def test_what_is_left_has_a_scale_of_its_own_below_what_was_there():
    """Before up to 100 sigma, after within a few."""
    before, after = figures.residual_panels(RECORDED, "time")
    assert before.get_ylim()[1] > 90 and after.get_ylim()[1] < 6
    assert before.get_title(loc="left").startswith("Before: ") and after.get_title(loc="left").startswith("After: ")
    (alone,) = figures.residual_panels(replace(COMPLETE, pictures=RECORDED.pictures), "time")
    assert not alone.get_title(loc="left").startswith("Before")


def test_the_error_falls_to_a_floor_with_the_share_of_the_starts_hatched():
    """From 150 to 3 mm with 3 mm of noise, of whose variance the starts take 4 %: a perfect model would show 2.94 mm."""
    (axes,) = figures.error_panel(EFFECT)
    fitted, held_out, noise = (line.get_ydata() for line in axes.lines)
    assert list(fitted) == pytest.approx([150.0, 3.0]) and list(held_out) == pytest.approx([150.0, 3.0])
    assert noise[0] == pytest.approx(3.0) and axes.get_ylabel() == "rms error [mm]"
    assert not axes.patches  # 0.06 of 150 mm is thinner than a line
    assert "down to the noise: 150 mm -> 3 mm" in axes.get_title(loc="left").replace("\n", " ")
    near = [step | {key: min(step[key], 0.005) for key in ("fitted", "held_out")} for step in EFFECT.steps]
    (axes,) = figures.error_panel(replace(EFFECT, steps=tuple(near)))  # from 5 to 3 mm
    (band,) = axes.patches
    assert band.get_y() == pytest.approx(3.0 * np.sqrt(0.96)) and band.get_y() + band.get_height() == pytest.approx(3.0)
    assert [label.get_text() for label in axes.get_xticklabels()] == ["as it is", "+ quadratic drag"]
    wrong = replace(EFFECT, parameters={"quadratic_drag": {"drag_coefficient": number(0.403, 0.002, stated=0.47)}})
    (axes,) = figures.error_panel(wrong)
    assert [label.get_text().replace("\n", " ") for label in axes.get_xticklabels()] == ["as it is", "quadratic drag corrected"]
    (axes,) = figures.error_panel(UNEXPLAINED)
    assert "not down to the noise" in axes.get_title(loc="left").replace("\n", " ")


def test_a_caption_tells_of_a_lower_panel_only_where_there_is_one():
    captions = {name: caption for name, (_, caption) in figures.pictures(replace(COMPLETE, pictures=RECORDED.pictures)).items()}
    assert "lower panel" not in captions["residuals_time"] and "lower panel" in figures.pictures(RECORDED)["residuals_time"][1]


def test_residuals_are_drawn_against_what_varies():
    """What slides on a level floor has one height, and a picture against it shows nothing."""
    assert figures.against(RECORDED.pictures) == ["time", "height", "speed"]
    flat = RECORDED.pictures.before | {"height": 0.02 + 1e-12 * RECORDED.pictures.before["height"]}
    assert figures.against(replace(RECORDED.pictures, before=flat)) == ["time", "speed"]


def test_the_title_of_the_error_tells_the_error_that_the_report_tells():
    """The one on recordings left out: 4 mm, where 3 mm are left on the fitted ones."""
    error = EFFECT.error | {"held_out": EFFECT.error["held_out"] | {"after": 0.004}}
    (axes,) = figures.error_panel(replace(EFFECT, error=error))
    assert "-> 4 mm" in axes.get_title(loc="left").replace("\n", " ")


def test_what_remains_is_drawn_from_zero_where_all_sets_leave_about_as_much():
    """Candidates that leave 1.02 to 1.03 all look like the model as it is, which leaves 1.03."""
    near = tuple(
        replace(entry, remains=entry.remains | {"chi2_per_freedom": 1.02}) for entry in COMPLETE.candidates if entry.remains
    )
    steps = tuple(step | {"chi2_per_freedom": 1.03} for step in COMPLETE.steps)
    (axes,) = figures.ranking_panel(replace(COMPLETE, candidates=near, steps=steps))
    assert axes.get_xlim()[0] == 0


def test_the_ranking_shows_what_remains_and_tells_the_foreseen_from_the_fitted():
    (axes,) = figures.ranking_panel(EFFECT)
    marks = {round(float(line.get_xdata()[0])): line.get_markerfacecolor() for line in axes.lines if line.get_marker() == "o"}
    assert sorted(marks) == [1, 40, 2500] and marks[40] == "white" and marks[1] != "white"
    assert [label.get_text() for label in axes.get_yticklabels()] == ["as it is", "uniform_flow", "quadratic_drag"]
    assert axes.get_title(loc="left").replace("\n", " ") == "Down from 2500 to 1 with quadratic drag"


def test_a_spectrum_is_drawn_only_where_a_period_hides():
    swing = LEFT + 0.01 * np.sin(2 * np.pi * 15.0 * np.arange(50) / 100)
    found = replace(UNEXPLAINED, pictures=pictures(table(swing), table(swing)))
    assert "spectrum" in figures.pictures(found) and "spectrum" not in figures.pictures(RECORDED)
    (axes,) = figures.spectrum_panel(found)
    assert axes.get_xlabel() == "frequency [Hz]" and "15" in axes.get_title(loc="left")


def test_every_picture_draws_into_given_axes_and_names_its_units():
    for draw in (figures.fit_panel, figures.ranking_panel, figures.error_panel):
        (own,) = draw(RECORDED)
        assert draw(RECORDED, own)[0] is own
    told = [axes.get_xlabel() + axes.get_ylabel() for axes, _ in figures.pictures(RECORDED).values() for axes in axes]
    assert all("[" in labels or "chi-square" in labels for labels in told)
    assert len(AMBIGUOUS.plot()) == len(RECORDED.plot()) == 4


def test_groups_of_a_table_are_named_by_what_they_hold():
    """Rows that nobody grouped are left out in blocks: seven heights in six blocks are told by their heights, not numbered."""
    heights = np.repeat(np.arange(0.5, 4.0, 0.5), 3)
    rows = {"trial": np.repeat([0, 1, 2, 2, 3, 4, 5], 3), "channel": np.zeros(21), "input": heights, "measured": heights}
    rows |= {"residual": np.full(21, 0.1), "sigmas": np.ones(21), "model": heights}
    blocks = tuple(f"block {number}" for number in range(1, 7))
    for names, told, label in [
        (blocks, ["0.5", "1", "1.5 to 2", "2.5", "3", "3.5"], "height [m]"),
        (tuple("abcdef"), list("abcdef"), "group"),
    ]:
        shown = Pictures(rows, rows, names, "input", "height_m")
        (axes, _), caption = figures.pictures(replace(EFFECT, pictures=shown))["residuals_by_recording"]
        assert [tick.get_text().replace("\n", " ") for tick in axes.get_xticklabels()] == told
        assert axes.get_xlabel() == label and "group of rows" in caption and "recording" not in caption


def test_another_number_of_axes_than_panels_is_refused_with_the_number_that_is_wanted():
    (one,) = figures.error_panel(RECORDED)
    for draw, given, words in [
        (RECORDED.plot, one, "ax holds 1 Axes; this picture has 4: give 4"),
        (RECORDED.plot, [one] * 5, "ax holds 5 Axes"),
        (lambda ax: figures.fit_panel(RECORDED, ax), [one, one], "ax holds 2 Axes; this picture has 1"),
        (RECORDED.plot, "axes", "ax holds 'axes'; give Axes of matplotlib, 4 of them"),
        (RECORDED.plot, one.figure, "give Axes of matplotlib"),
    ]:
        with pytest.raises(InputError, match=words):
            draw(given)


def test_colours_differ_in_grey():
    """Rec. 709 luma of before, after and the marks of the first channels: a tenth of the way from black to white apart."""

    def luma(colour):
        return np.dot([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)], [0.2126, 0.7152, 0.0722])

    from hlcs.report.figures import AFTER, BEFORE, CHANNEL

    assert abs(luma(BEFORE) - luma(AFTER)) > 0.2
    first = sorted(luma(colour) for _, colour in CHANNEL[:3])
    assert min(np.diff(first)) > 0.1 and len({mark for mark, _ in CHANNEL}) == len(CHANNEL)


def clearances(axes):
    """Of every mark: from its centre to the nearer of the lower and the upper edge of the Axes, less its radius [points]."""
    axes.figure.canvas.draw()
    low, high = axes.bbox.extents[[1, 3]]
    return [
        (min(y - low, high - y) * 72 / axes.figure.dpi) - line.get_markersize() / 2
        for line in axes.lines
        if line.get_marker() not in ("None", "")
        for y in axes.transData.transform(line.get_xydata())[:, 1]
    ]


def test_no_mark_is_cut_at_the_edge_of_its_panel():
    """Three candidates in a ranking; groups whose errors lie near each other, far from zero."""
    near = pictures(table(LEFT + 0.01), table(LEFT))
    few = replace(EFFECT, candidates=EFFECT.candidates[:2])
    panels = [
        *figures.ranking_panel(few),
        *figures.recording_panels(replace(EFFECT, pictures=near)),
        *figures.error_panel(COMPLETE),
    ]
    assert all(min(clearances(axes)) > 0 for axes in panels)


def test_the_title_of_the_ranking_is_not_cut_off_by_long_names():
    """Names to the left narrow the panel: title and name of the axis still end within the picture."""
    longest = "velocity_dependent_restitution"
    pair = ("restitution", longest)
    steps = tuple(step | ({"effects": list(pair)} if step["effects"] else {}) for step in EFFECT.steps)
    found = replace(EFFECT, effects=pair, steps=steps)
    (axes,) = figures.ranking_panel(found)
    assert any(longest in label.get_text() for label in axes.get_yticklabels())
    figure = axes.figure
    figure.canvas.draw()
    texts = [*axes.texts, axes.xaxis.label, axes._left_title]
    assert all(text.get_window_extent().x1 <= figure.bbox.x1 for text in texts)

"""The sentences of a report belong to the verdict and to the numbers: planted diagnoses, told word for word."""

import re
from dataclasses import replace

import numpy as np
import pytest
from planted import (
    ALL,
    AMBIGUOUS,
    COMPLETE,
    DRAG,
    EFFECT,
    NOISE,
    REBOUND,
    UNEXPLAINED,
    WIND,
    diagnosis,
    finding,
    number,
    pictures,
)
from planted import table as observations

from hlcs.data.notes import OutOfTime, Stopped
from hlcs.records import Comparison, Reason
from hlcs.report.ranking import ranking
from hlcs.report.sentences import effect_sentence


def text(found, **more):
    """The printed report with single spaces, so that line breaks do not matter."""
    return " ".join(found.summary(**more).split())


def opening(found):
    """The sentences before the first heading."""
    return " ".join(found.summary().split("\n\n")[1].split())


def test_what_is_missing_is_said_first_with_its_number_and_what_it_removes():
    """0.15 m before, 3 mm after: 98 % are gone, and 3 mm is the noise."""
    assert opening(EFFECT) == (
        "Air resistance is missing (quadratic drag, drag coefficient 0.4965 +- 0.0010). It removes 98 % of the error: 150 mm "
        "before, 3 mm after, on recordings that its numbers were not fitted to. What is left is your noise (3 mm)."
    )


def test_a_number_that_was_wrong_is_corrected_not_missing():
    found = diagnosis(found=(REBOUND,), parameters={"restitution": {"coefficient": number(0.737, 0.002, stated=0.75)}})
    assert opening(found).startswith("Restitution is 0.7370 +- 0.0020, not 0.75. ") and "missing" not in opening(found)


def test_what_is_no_law_is_shown_by_the_data_and_not_missing():
    assert "The data show a clock at a wrong rate (time scale, factor 1.0300 +- 0.0010)." in opening(AMBIGUOUS)
    assert "missing" not in opening(AMBIGUOUS)


def test_what_the_file_implies_and_the_data_do_not_show_is_not_said_to_be_missing_in_them():
    lift = replace(finding("buoyancy", "the lift of the displaced air", True, chi2=1.0, error=NOISE), reason=Reason.IMPLIED)
    told = diagnosis(found=(DRAG, lift), parameters={"buoyancy": {"fluid_density": number(1.2, 0.07, "kg/m3")}})
    sentence = effect_sentence(told, "buoyancy")
    assert sentence.startswith("The lift of the displaced air follows from what the file states (buoyancy, fluid density 1.2")
    assert sentence.endswith("by itself it would not be proved here.")


def test_every_member_of_an_ambiguous_set_has_its_number():
    assert "Each of these explains the data as well as the other" in opening(AMBIGUOUS)
    assert "(length scale, factor 1.0600 +- 0.0020)" in opening(AMBIGUOUS)
    assert {line.split()[0] for line in str(AMBIGUOUS).splitlines() if " factor " in line} >= {"time_scale", "length_scale"}


def test_what_all_sets_hold_is_said_once_and_before_the_choice():
    both = [{**AMBIGUOUS.sets[k], "effects": ["quadratic_drag", name]} for k, name in enumerate(("time_scale", "length_scale"))]
    parameters = AMBIGUOUS.parameters | EFFECT.parameters
    found = replace(AMBIGUOUS, sets=tuple(both), parameters=parameters, candidates=(*AMBIGUOUS.candidates, DRAG))
    told = opening(found)
    assert told.startswith("Air resistance is missing") and told.count("Air resistance") == 1
    assert "Beside that, each of these" in told


def test_an_unexplained_misfit_says_what_is_explained_and_what_is_left_beyond_the_noise():
    """5 mm are left of 150 mm, with a noise of 3 mm: sqrt(5^2 - 3^2) = 4 mm are beyond it, and of the excess of chi-square
    1 - (25/9 - 1)/(2500 - 1) = 99.93 % is gone."""
    told = opening(UNEXPLAINED)
    assert told.startswith("Air resistance explains 99.9 % of the misfit beyond the noise (quadratic drag")
    assert "Beyond the noise 4 mm are left that none of the effects tried explains." in told
    assert "your noise" not in told and "no candidate" not in told and "is missing" not in told


TOO_SMALL = {
    "sigma": 0.003,
    "known": 0.001,
    "unit": "m",
    "source": "stated",
    "seen": "smooth curves through the recordings leave",
    "remedy": "e.toml, line 9: measurement.noise, position = 0.003",
    "next": "record a body at rest",
}


def test_where_the_data_show_more_noise_than_is_stated_that_is_said_first_and_nothing_is_said_to_be_missing():
    """In the details and behind the line to add neither: what is left may be the noise alone."""
    bare = text(diagnosis("unexplained", found=(), parameters={}, noise_shown=TOO_SMALL), details=True)
    told = bare.split("unexplained ")[1]
    assert told.startswith(
        "The stated noise may be too small: it is 1 mm, and smooth curves through the recordings leave 3 mm, whatever the model. "
        "With a noise of 3 mm the model as it is agrees with the data, and nothing need be missing. The line to write: e.toml, "
        "line 9: measurement.noise, position = 0.003; then run it again."
    )
    assert "Something is missing" not in bare and "more is missing" not in bare and "Where the model still misses" not in bare
    told = opening(replace(UNEXPLAINED, noise_shown=TOO_SMALL))
    assert told.startswith("The stated noise may be too small") and "Air resistance explains 99.9 % of the misfit" in told
    assert "nothing else need be missing" in told and "none of the effects" not in told
    assert opening(comparison(noise_shown=TOO_SMALL)).startswith(
        "The model misses the measurement by 30 mm. The stated noise may be too small: it is 1 mm"
    )
    at_rest = opening(comparison(noise_shown=TOO_SMALL | {"source": "static recording"}))
    assert "The noise of the body at rest may be too small" in at_rest


STARTS = {
    "effects": [],
    "differ": {"velocity": {"least": 0.02, "most": 0.13, "unit": "m/s"}},
    "next": "leave start out of the trials that state it",
}


def test_starts_that_are_stated_wrongly_are_said_first_and_nothing_is_said_to_be_missing():
    bare = text(diagnosis("unexplained", found=(), parameters={}, starts_shown=STARTS), details=True)
    told = bare.split("unexplained ")[1]
    assert told.startswith(
        "Either the starts that the file states are wrong: with starts fitted to the data in their place the model as it is "
        "agrees with the data, and nothing need be missing. They differ from those stated by 0.02 m/s to 0.13 m/s (velocity)."
    )
    assert "Something is missing" not in bare and "more is missing" not in bare and "Where the model still misses" not in bare
    assert "To know it, leave start out of the trials that state it." in told
    told = opening(replace(UNEXPLAINED, starts_shown=STARTS))
    assert "nothing else need be missing" in told and "Air resistance explains 99.9 % of the misfit" in told
    assert "Either the starts that the file states are wrong" in opening(comparison(starts_shown=STARTS))


def test_where_nothing_stands_the_nearest_is_named_with_the_reason_why_it_does_not():
    near = finding("mass_offset", "a mass other than stated", reason=Reason.SUSPECTED, chi2=100.0, error=0.03, why="suspected: x")
    found = diagnosis("unexplained", found=(), others=(near,), parameters={}, after=0.15, explained=None)
    told = opening(found)
    assert told.startswith("Something is missing that none of the effects tried explains.")
    assert (
        "Nearest comes a mass other than stated (mass offset), which would take away 96 %" in told
        and "does not fall as it should on recordings" in told
    )


def test_a_complete_model_is_said_to_be_so_and_nothing_else():
    assert opening(COMPLETE).startswith("Nothing is missing at the precision of these data. The model misses by 3 mm.")


def test_a_number_beyond_what_is_usual_is_told_as_such():
    beyond = "3.1 lies above what is plausible (0 to 2)"
    odd = {"quadratic_drag": {"drag_coefficient": number(3.1, 0.1, usual="0 to 2", beyond=beyond)}}
    assert f"The drag coefficient of {beyond}: check the inputs that it rests on." in opening(diagnosis(parameters=odd))
    odd["quadratic_drag"]["drag_coefficient"]["rests_on"] = "mass and size of the body"
    told = opening(diagnosis(parameters=odd))
    assert f"The drag coefficient of {beyond}: check the inputs that it rests on (mass and size of the body)." in told


def test_an_error_above_the_noise_is_never_called_noise():
    """An adequate model may leave more than the noise of the table: what another campaign would change, for one."""
    found = diagnosis(after=3 * NOISE)
    assert "What is left is your noise" not in text(found) and "cannot be told from your noise (3 mm)" in text(found)


def test_a_number_that_the_data_do_not_show_is_told_to_be_none():
    nothing = {"value": None, "low": None, "high": None, "unit": "m/s", "why": "these data do not show it", "left_out": 0.0}
    told = text(
        diagnosis(found=(WIND,), parameters={"uniform_flow": {"velocity_z": number(-0.5, 0.1, "m/s"), "velocity_y": nothing}})
    )
    assert "velocity z -0.50" in told and "uniform_flow velocity_y is not told: these data do not show it." in told
    assert "withheld" not in told


def test_a_law_of_drag_that_does_not_hold_is_told_at_once_and_one_that_does_beside_its_number():
    reach = {"least": 8e3, "most": 2e4, "told": "The data reach Reynolds numbers of 8,000 to 20,000."}
    holding, failing = (replace(EFFECT, reynolds={"quadratic_drag": reach | {"holds": holds}}) for holds in (True, False))
    told = "Quadratic drag: the data reach Reynolds numbers of 8,000 to 20,000."
    assert told in text(holding).split("The numbers")[1] and told not in opening(holding)
    assert told in opening(failing) and text(failing).count(told) == 1


def test_what_only_absorbs_is_told_and_stands_nowhere_among_what_was_found():
    found = diagnosis("unexplained", found=(), others=(WIND,), parameters={}, absorbing={"uniform_flow": {"u": number(1.0, 0.1)}})
    assert "A steady flow of the air would take less than half of it away" in opening(found)
    told = found.to_json()
    assert told["parameters"] == {} and "absorbing" not in told and "The numbers" not in text(found)


def known_badly(verdict, fitted, held_out):
    error = {"before": 0.012, "noise": NOISE}
    errors = {"measure": "rms", "unit": "m", "fitted": error | {"after": fitted}, "held_out": error | {"after": held_out}}
    return diagnosis(verdict, after=fitted, error=errors)


def test_what_is_left_is_judged_on_the_data_themselves_and_the_error_on_others_is_told_beside_it():
    """5.43 mm are not noise of 3 mm: 2.99 mm are, and the numbers are less certain."""
    told = opening(known_badly("effect", 0.00299, 0.00543))
    assert "5.43 mm after, on recordings that its numbers were not fitted to" in told
    assert "On the recordings themselves 2.99 mm are left, which is your noise (3 mm). That the error is larger on" in told
    assert "with less certainty: more or other recordings tell the numbers better" in told
    assert "What is left" not in told
    assert "What is left is your noise (3 mm)" in opening(known_badly("effect", 0.00299, 0.00302))
    told = opening(known_badly("unexplained", 0.004, 0.008))
    assert "On the recordings themselves the error falls from 12 mm to 4 mm, on recordings that the numbers were not" in told
    assert "fitted to 8 mm are left; the noise is 3 mm. Beyond the noise 2.65 mm are left" in told


@pytest.mark.parametrize("verdict", sorted(ALL))
def test_no_report_of_any_verdict_says_what_is_false_for_it(verdict):
    told = text(ALL[verdict], details=True)
    assert told.startswith(f"a ball (trajectory): {verdict}")
    assert "nan" not in told and "None" not in told and "{" not in told.split("To add it")[0]
    assert ("What is left is your noise" in told) == (verdict in ("effect", "ambiguous", "complete"))
    assert ("none of the effects tried explains" in told) == (verdict == "unexplained")
    assert ("is missing (" in told) == (verdict == "effect")


def test_p_is_never_below_what_the_draws_can_show():
    """Of 600 draws none was larger: p is at most 1/601 = 0.0017, and no smaller number is printed anywhere."""
    told = text(EFFECT, details=True)
    assert "p = 0.0017 at most (none of 600 draws of noise alone was as large)" in told
    assert all(float(p) >= 1 / 601 for p in re.findall(r"p = ([0-9.e-]+)", told))


def test_the_ranking_is_by_what_remains_and_every_error_has_its_unit():
    rows = [line for line in EFFECT.summary().split("What remains\n")[1].split("\n\n")[0].splitlines()[1:4]]
    assert [row.replace("*", "").split("  ")[1].strip() or row.split()[1] for row in rows][0].startswith("quadratic_drag")
    assert "3 mm" in rows[0] and "~40" in rows[1] and "the model as it is" in rows[2] and "150 mm" in rows[2]
    assert [row["chi2_per_freedom"] for row in ranking(EFFECT)] == pytest.approx([1.0, 40.0, 2500.0])
    assert [row["foreseen"] for row in ranking(EFFECT)] == [False, True, False]


def test_where_nothing_is_missing_sets_that_leave_as_much_are_counted_and_not_listed():
    """Of chi-squares of 1, 0.99 and 0.97 the last alone is smaller by more than 2 %."""
    others = [replace(WIND, effect=name, remains=WIND.remains | {"effects": [name]}) for name in ("uniform_flow", "magnus")]
    same, less = (
        replace(each, remains=each.remains | {"chi2_per_freedom": chi2}) for each, chi2 in zip(others, (0.99, 0.97), strict=True)
    )
    told = replace(COMPLETE, candidates=(same, less)).summary().split("What remains\n")[1].split("\n\n")[0]
    assert "the model as it is" in told and "magnus" in told and "uniform_flow" not in told
    assert "1 more leave no less, to 2 %" in " ".join(told.split())


def test_details_are_added_and_nothing_is_taken_away():
    short, long = EFFECT.summary(), EFFECT.summary(details=True)
    assert short.rsplit("\n\n", 1)[0] in long and "Details: the candidates" in long and "Details" not in short


def test_a_period_that_hides_in_what_is_left_is_told():
    """A swing of 8 Hz and 9 mm in noise of 3 mm, four recordings of 2 s."""
    times, generator = np.arange(200) / 100, np.random.default_rng(1)
    swing = 0.009 * np.sin(2 * np.pi * 8.0 * times) + NOISE * generator.standard_normal(200)
    left = observations(swing)
    found = replace(UNEXPLAINED, pictures=pictures(left, left))
    told = re.search(r"it swings ([0-9.]+) times a second in z .*?([0-9.]+) mm to either side", opening(found))
    assert float(told[1]) == pytest.approx(8.0, abs=0.5)  # the resolution of a recording of 2 s
    assert float(told[2]) == pytest.approx(9.0, abs=1.0)  # the noise moves an amplitude by 3 mm sqrt(2/200) = 0.3 mm


def test_what_swings_in_the_picture_is_to_be_compared_with_a_mark_that_stands_still():
    """Positions that swing may be the camera; a rotation that swings is not."""
    swing = 0.009 * np.sin(2 * np.pi * 8.0 * np.arange(200) / 100)
    still = observations(NOISE * np.random.default_rng(1).standard_normal(200))
    left, turning = observations(swing), observations(swing)
    turning["channel"] = np.full(len(turning["channel"]), 5)
    told = [text(replace(UNEXPLAINED, pictures=pictures(table, table))) for table in (left, turning, still)]
    assert ["keep a mark that stands still in the view" in each for each in told] == [True, False, False]
    assert "keep a mark" not in text(replace(EFFECT, pictures=pictures(left, left)))


def test_rotations_have_an_error_of_their_own_beside_that_of_positions():
    """Rotations are missed by 0.2 rad before and by 0.005 rad after: no error in millimetres holds that."""

    def both(turned):
        two = [observations(np.full(20, NOISE)), observations(np.full(20, turned))]
        two[1]["channel"] = np.full(80, 5)
        return {key: np.concatenate([one[key] for one in two]) for key in two[0]}

    shown = pictures(both(0.2), both(-0.005))
    told = opening(diagnosis(pictures=shown, noise={"position": NOISE, "orientation": 0.0051}))
    assert told.endswith("that of the rotations goes from 0.2 rad to 0.005 rad (noise 0.0051 rad).")
    assert "rotations" not in opening(diagnosis(pictures=pictures(observations([1.0]), observations([1.0]))))


def comparison(**more):
    told = {
        "kind": "trajectory",
        "title": "a ball",
        "adequate": False,
        "statistic": 30.0,
        "p": 1 / 601,
        "error": {"rms": 0.03, "noise": NOISE, "unit": "m", "bias": 0.012},
        "where": ({"trial": "a.csv", "channel": "z", "phase": "flight", "rms": 0.05, "sigma": 17.0},),
        "noise": {"source": "stated"},
    }
    return Comparison(**told | more)


def test_a_comparison_opens_in_plain_words_with_the_sign_in_words():
    assert opening(comparison()) == (
        "The model misses the measurement by 30 mm, 10 times the noise (3 mm). On average the model reads 12 mm more than was "
        "measured. It misses most in a.csv: 50 mm, 17 times the noise."
    )
    right = comparison(adequate=True, error={"rms": 0.003, "noise": NOISE, "unit": "m", "bias": -0.001})
    assert opening(right) == "The model agrees with the measurement: it misses by 3 mm, which is your noise (3 mm)."
    assert "Statistic" in text(comparison(), details=True) and "Statistic" not in text(comparison())


def test_a_comparison_without_a_known_noise_judges_nothing():
    unknown = comparison(adequate=None, error={"rms": None, "noise": None, "unit": "m"}, where=(), advice="record a body at rest")
    assert "unknown" in opening(unknown) and "To know it, record a body at rest." in opening(unknown)


def test_candidates_of_one_reason_stand_together_with_it():
    """Wind takes away 98 % of chi-square, and still leaves more than the drag."""
    told = text(diagnosis(others=(WIND, replace(WIND, effect="time_scale"))))
    assert "- uniform_flow, time_scale: a part is explained, not as well as by what was found" in told
    nothing = text(replace(diagnosis("unexplained", found=(), others=(WIND,)), effects=()))
    assert "uniform_flow: a part is explained, and more than noise is left" in nothing and "by what was found" not in nothing
    little = replace(WIND, remains=WIND.remains | {"chi2_per_freedom": 2490.0})
    assert "- uniform_flow: less than 2 % of the misfit is explained." in text(diagnosis(others=(little,)))
    suspected = replace(WIND, reason=Reason.SUSPECTED)
    assert "- uniform_flow: a part is explained, not as well as by what was found" in text(diagnosis(others=(suspected,)))
    suspected = replace(suspected, remains=WIND.remains | {"chi2_per_freedom": 1.0})  # it leaves as little as the drag
    assert "- uniform_flow: the misfit would fall, but not enough on data that" in text(diagnosis(others=(suspected,)))


def test_what_would_do_instead_is_one_of_several_and_not_all_of_them():
    """Drag, or a ruler, or a clock: "and" would say that ruler and clock are both needed."""
    told = opening(replace(UNEXPLAINED, ambiguous=(("quadratic_drag", "length_scale", "time_scale"),)))
    assert "In place of quadratic drag length scale or time scale would do as well." in told


def test_a_candidate_that_leaves_as_little_is_not_said_to_explain_less():
    """Alone it leaves the chi-square of what was found; or a set with it, of some weight, leaves the error of what was found."""
    alone = replace(WIND, remains=WIND.remains | {"chi2_per_freedom": 1.001, "foreseen": False})
    told = text(diagnosis(others=(alone,)))
    assert "uniform_flow: what is left is as little as with what was found" in told and "a part is explained" not in told
    beside = replace(WIND, fitted=NOISE)
    told = text(replace(diagnosis(others=(beside,)), inclusion={"uniform_flow": 0.18}))
    assert "uniform_flow: beside others, as little is left as with what was found" in told
    useless = text(replace(diagnosis(others=(beside,)), inclusion={"uniform_flow": 0.001}))
    assert "uniform_flow: a part is explained" in useless
    looser = replace(AMBIGUOUS.candidates[1], remains=AMBIGUOUS.candidates[1].remains | {"chi2_per_freedom": 1.2})
    told = text(replace(AMBIGUOUS, candidates=(AMBIGUOUS.candidates[0], looser, replace(alone, remains=looser.remains))))
    assert "uniform_flow: a part is explained" not in told  # a member of the set leaves 1.2 as well


@pytest.mark.parametrize(("count", "needed"), [(1, "less usual numbers are needed"), (3, "more numbers are needed")])
def test_more_numbers_are_only_said_to_be_needed_of_a_candidate_that_has_more(count, needed):
    """The drag that was found has one; a candidate that leaves as little with one as well asks for a less usual one."""
    found = diagnosis(others=(replace(WIND, remains=WIND.remains | {"chi2_per_freedom": 1.001, "numbers": count}),))
    drag = replace(found.candidates[0], remains=found.candidates[0].remains | {"numbers": 1})
    assert f"as little as with what was found, but {needed}" in " ".join(
        text(replace(found, candidates=(drag, *found.candidates[1:]))).split()
    )


@pytest.mark.parametrize(("kind", "left_out"), [("trajectory", "recordings"), ("outcomes", "rows"), ("layers", "layers")])
def test_what_was_held_out_is_called_by_its_name(kind, left_out):
    assert f"on {left_out} that its numbers were not fitted to" in opening(replace(EFFECT, kind=kind))


def test_a_search_that_was_stopped_says_so_before_anything_else():
    stopped = replace(UNEXPLAINED, notes=(Stopped("whatever it says"),))
    assert opening(stopped).startswith("Stopped by Ctrl-C before the search ended: what follows holds for the sets of effects")
    assert stopped.summary().split("\n")[0] == "a ball (trajectory): unexplained (stopped by Ctrl-C before the search ended)"
    assert "nothing that was fitted by then explains" in opening(stopped) and "library" not in opening(stopped)
    assert "Ctrl-C" not in opening(UNEXPLAINED)


@pytest.mark.parametrize(("verdict", "told"), [("effect", True), ("ambiguous", True), ("unexplained", False)])
def test_what_was_not_fitted_for_time_is_told_beside_a_model_that_explains_the_data(verdict, told):
    """Where nothing explains them, that is so of what was tried, and said so already."""
    found = replace(diagnosis(verdict), notes=(OutOfTime("sets that might do as well (19)"),))
    assert ("were not fitted, for time" in opening(found)) == told and "might do as well (19)" in text(found)
    assert "for time" not in opening(diagnosis(verdict))


@pytest.mark.parametrize(
    ("after", "told"), [(0.0132, "stays near 13.2 mm"), (0.02, "does not fall (13.2 mm before, 20 mm after)")]
)
def test_an_error_that_does_not_fall_is_not_said_to_fall(after, told):
    """An effect may explain rotations alone, or nothing beside the others: the error of the positions stays as it is."""
    found = opening(diagnosis("unexplained", before=0.0132, after=after, explained=0.87))
    assert f"The error (root mean square) {told}; what falls is the square of the misfit" in found
    assert "falls from" not in found and "the noise is 3 mm" in found


def test_what_sets_that_do_as_well_leave_is_told_of_each_where_it_differs():
    """13.2 mm and 14.5 mm of 30.9 mm: 57 % and 53 % are gone."""
    sets = tuple({**entry, "held_out": left} for entry, left in zip(AMBIGUOUS.sets, (0.0132, 0.0145), strict=True))
    error = {"before": 0.0309, "after": 0.0132, "noise": 0.0125}
    errors = {"measure": "rms", "unit": "m", "fitted": error, "held_out": error}
    told = opening(replace(AMBIGUOUS, sets=sets, error=errors))
    assert "Each of them removes 53 to 57 % of the error: 30.9 mm before, 13.2 to 14.5 mm after, on recordings" in told
    alike = tuple({**entry, "held_out": 0.0132} for entry in sets)
    assert "Each of them removes 57 % of the error: 30.9 mm before, 13.2 mm after, on" in opening(
        replace(AMBIGUOUS, sets=alike, error=errors)
    )
    alone = replace(AMBIGUOUS, sets=sets, error={**errors, "held_out": None}, candidates=(AMBIGUOUS.candidates[0],))
    assert "The first of them removes 57 % of the error" in opening(alone)


def test_a_number_whose_interval_holds_what_is_stated_is_not_called_otherwise():
    tilts = {"angle_x": number(0.0, 0.03, stated=0.0), "angle_y": number(-0.055, 0.001, stated=-0.07)}
    sentence = effect_sentence(diagnosis(parameters={"tilted_gravity": tilts}), "tilted_gravity")
    assert sentence == "Tilted gravity is not as stated: angle y -0.0550 +- 0.0010, not -0.07."

"""The numbers of fitted sets as they are told: their intervals, which are withheld, and what is doubtful about them."""

import numpy as np
from scipy import optimize, special

from hlcs.effects.witnesses import INPUTS_OF
from hlcs.estimation.fitting import chi2_of
from hlcs.selection.thresholds import INTERVAL
from minibullet.errors import InputError


def parameters_of(sets, final, chosen):
    """{effect: {number: value, low, high, unit}} of all effects of some sets; final: {set: its final Fit}, that of the best of
    all among them, of the others that of the search counts."""
    fits = {members: final.get(members, sets.search.fits[members]) for members in chosen}
    numbers = {}
    for name in dict.fromkeys(name for members in chosen for name in sets.ordered(members)):
        entry = sets.search.candidates[name]
        holding = [(sets.weights[members], fits[members]) for members in chosen if name in members]
        freedom = final[sets.best].freedom
        numbers[name] = {
            free.name: _withheld(holding[0][1], entry, free)
            or annotated(_of_both_signs(sets, chosen, name, free, _interval(sets, holding, name, free, freedom)), free, entry)
            for free in entry.free
        } | {constant: {"value": value, "low": value, "high": value, "unit": "1"} for constant, value in entry.constants}
    return numbers


def _interval(sets, holding, name, free, freedom):
    """{value, low, high, unit} of a number; holding: [(weight, Fit)] of the sets that hold it."""
    known = [(max(weight, 1e-12), *_number(fit, name, free.name, sets.overdispersion)) for weight, fit in holding]
    return interval(known, free, freedom)


def _of_both_signs(sets, chosen, name, free, number):
    """The number with an interval to both sides of its absence, where beyond the first one the other sign explains the data as
    well: a wind across the picture of a camera. chosen: sets, the heaviest first."""
    entry, problem = sets.search.candidates[name], sets.search.problem
    if entry.setting or free.null is None or not free.least <= (mirrored := 2 * free.null - number["value"]) <= free.most:
        return number
    if number["low"] <= mirrored <= number["high"]:  # a number near its absence has both signs in its interval
        return number
    fit = sets.search.fits[next(members for members in chosen if name in members)]
    place = fit.model.terms_named(name)
    models = [fit.model.with_at(place, fit.model.terms[place].numbers | {free.name: at}) for at in (number["value"], mirrored)]
    try:
        chi2 = [sum(chi2_of(problem.white_residuals(model, fit.initial_states))) for model in models]
    except InputError:
        return number
    if not chi2[1] - chi2[0] < sets.overdispersion * special.chdtri(1, 1 - INTERVAL):
        return number
    ends = [number["low"], number["high"], 2 * free.null - number["low"], 2 * free.null - number["high"]]
    return number | {"low": max(min(ends), free.least), "high": min(max(ends), free.most), "mirrored": mirrored}


def annotated(number, free, entry):
    """A number with what a reader must know beside it: what the model states, and what is usual where all of its interval lies
    beyond that: where a part does not, the data only do not give it."""
    stated = {"stated": free.null} if entry.setting and free.null is not None else {}
    may_be_usual = "mirrored" not in number and number["low"] <= free.high and number["high"] >= free.low
    beyond = "" if may_be_usual else free.beyond(number["value"])
    beyond = beyond or ("" if stated else free.unlike_stated(number["low"], number["value"], number["high"]))
    doubtful = {"usual": free.usual, "beyond": beyond, "rests_on": INPUTS_OF.get(entry.name, "")}
    return number | stated | (doubtful if beyond else {})


def _withheld(fit, entry, free):
    """The entry of a number that a fit does not give, or that the data do not show; else None.

    The data show a number where they tell more of it than was believed beforehand. One that they do not, and that is as it would
    be if it were left out, is best left out: a component of the wind across the picture of a camera. Not all numbers of an
    effect, which then were none.
    """
    nothing, why = {"value": None, "low": None, "high": None, "unit": free.unit}, fit.withheld.get((entry.name, free.name))
    if why or entry.setting or free.null is None:
        return why and nothing | {"why": why}

    def hidden(each):
        place = _place(fit, entry.name, each.name)
        return fit.information[place, place] < 1 and each.null is not None and abs(fit.estimate[place] - each.null) <= each.spread

    if not hidden(free) or all(map(hidden, entry.free)):
        return None
    there = f"{free.null:g} {'' if free.unit == '1' else free.unit}".rstrip()
    why = f"these data do not show it: near {there} nothing that was measured changes with it"
    return nothing | {"why": why, "left_out": free.null}


def shows(final, name):
    """Does a number of an effect in a final fit lie elsewhere than where the effect is absent, or has it no such place?"""
    places = [free for effect, free, _ in final.numbers if effect == name and free.null is not None]
    known = [free for free in places if (name, free.name) not in final.withheld]
    intervals = [interval([(1.0, *_number(final, name, free.name, 1.0))], free, final.freedom) for free in known]
    return not places or any(
        not number["low"] <= free.null <= number["high"] for free, number in zip(known, intervals, strict=True)
    )


def interval(parts, free, freedom):
    """A number with its 90 % interval, averaged over the sets that hold it.

    parts: [(weight, value, standard error, or one downwards and one upwards)], the best set first.

    The interval is that of the mixture of their laws (Student's t, half of it to each side); nothing is left out of it where the
    law of a number ends.
    """
    weights, values = np.array([part[:2] for part in parts]).T
    errors = np.array([np.broadcast_to(part[2], 2) for part in parts]).T
    value, weights = values[0], weights / weights.sum()

    def below(x):
        return float(weights @ special.stdtr(freedom, (x - values) / np.maximum(np.where(x < values, *errors), 1e-300)))

    reach = special.stdtrit(freedom, 0.5 + INTERVAL / 2) * errors * [[-1.0], [1.0]]
    outer = np.min(values + 2 * reach[0]), np.max(values + 2 * reach[1])
    low, high = (
        optimize.brentq(lambda x, tail=tail: below(x) - tail, *outer, xtol=1e-12)
        if len(parts) > 1 and np.max(errors) > 0
        else value + side
        for side, tail in zip(reach[:, 0], (0.5 - INTERVAL / 2, 0.5 + INTERVAL / 2), strict=True)
    )
    return {"value": float(value), "low": float(max(low, free.least)), "high": float(min(high, free.most)), "unit": free.unit}


def _place(fit, name, number):
    """Where a number of an effect stands among those of a fit."""
    return [(effect, free.name) for effect, free, _ in fit.numbers].index((name, number))


def _number(fit, name, number, overdispersion):
    """(value, standard errors downwards and upwards) of one number of a fit, wider where the model is not adequate."""
    place = _place(fit, name, number)
    error = float(np.sqrt(max(fit.covariance_at(overdispersion)[place, place], 0.0)))
    return fit.estimate[place], error * np.broadcast_to(fit.sides, (2, len(fit.estimate)))[:, place]


def doubts_of(fit, parameters):
    """Sentences on numbers beyond what is plausible, on numbers that hang together, and on a fit that did not come to its end;
    parameters: as they are told."""
    names = [f"{effect}.{free.name}" for effect, free, _ in fit.numbers]
    entries = [(name, parameters[effect][free.name]) for name, (effect, free, _) in zip(names, fit.numbers, strict=True)]
    notes = [
        f"{name} = {entry['beyond']}: check the inputs that it rests on" + f" ({entry['rests_on']})" * bool(entry["rests_on"])
        for name, entry in entries
        if "beyond" in entry
    ]
    rough = np.flatnonzero(np.abs(fit.step_error) > fit.errors)
    notes += [f"the time step tells {names[k]} worse than the data do: state a smaller time_step under [model]" for k in rough]
    correlation = fit.covariance / np.outer(fit.errors, fit.errors)
    hanging = zip(*np.nonzero(np.triu(np.abs(correlation) > 0.9, 1)), strict=True)
    notes += [f"{names[i]} and {names[j]} hang together: correlation {correlation[i, j]:+.2f}" for i, j in hanging]
    if not fit.converged:
        notes.append("the final fit did not come to its end: its numbers may be off by more than their intervals")
    return tuple(notes)

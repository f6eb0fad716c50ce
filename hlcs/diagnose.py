"""Diagnose: which effect is missing from the model. The order of the work, and the verdict."""

from dataclasses import replace

import numpy as np
from scipy import stats

from hlcs.compare import where_it_fails
from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.impacts import read_impacts, unlike
from hlcs.data.measurement import read_measurement
from hlcs.effects import check_names, own_classes, set_of
from hlcs.estimation.cross_validation import Folds
from hlcs.estimation.effort import LEFT_OUT, SMOOTH, cut, screened
from hlcs.estimation.noise_model import estimate_noise
from hlcs.kinds.thinning import on_all_rows, thinned
from hlcs.kinds.trajectories import judge, polished, prepare, touches
from hlcs.selection import experiment_design
from hlcs.selection.competing_models import rivals
from hlcs.selection.diagnosis import Diagnosis, Finding
from hlcs.selection.eligibility import candidates_for
from hlcs.selection.pairs import beside
from hlcs.selection.search import Search
from hlcs.selection.search_moves import exchanged, reformed, rerouted, submerged

INTERVAL = 0.90  # of coefficients


def diagnose(path, candidates=None, effects_file=None, seed=0, workers=None, progress=False, effects=None, allow_outside=False):
    """Find what is missing from the model of an experiment file; returns a Diagnosis.

    path: experiment file; candidates: names to try (None = the file's list, or all that fit); effects_file: Python file with
    effects of your own, run as code; effects: the same as classes or values; seed, workers: for layer data (paired simulations);
    progress: print what is being tried; allow_outside: let the experiment file name files outside its own folder. Raises
    InputError where the input is at fault.
    """
    file = read_experiment_file(path, allow_outside)
    own = own_classes(effects, effects_file)
    if candidates is None:
        candidates = file.candidates
    if file.kind == "layers":
        from hlcs.kinds.layers.diagnosis import diagnose_layers

        return diagnose_layers(file, candidates=candidates, own=own, seed=seed, workers=workers, progress=progress)
    check_names(file, own)
    measurement = read_measurement(file)
    say = _teller(progress)
    if file.kind == "outcomes":
        from hlcs.kinds.outcomes import diagnose_outcomes

        return diagnose_outcomes(measurement, candidates, own, say)
    return diagnose_trajectories(measurement, candidates, own, say)


def _teller(progress):
    """A function that shows what is being tried: on a terminal in one line, otherwise nothing."""
    if not progress:
        return lambda text: None
    from tqdm import tqdm

    bar = tqdm(bar_format="{desc} {elapsed}", leave=False, disable=None)

    def say(text):
        bar.set_description_str(text)
        bar.refresh()

    return say


def diagnose_trajectories(measurement, names=None, own=(), say=lambda text: None):
    """The diagnosis of recordings."""
    file = measurement.file
    say("fitting the model under test")
    noise = estimate_noise(measurement)
    contact = touches(measurement.trials, noise)
    whole, measurement = measurement, thinned(measurement, noise)
    few, many, notes = screened(measurement, contact)
    prepared = prepare(few, own, noise)
    if few is not many and prepared.problem is not None and not cut(prepared.problem):  # cheaper than feared
        few, many, notes = screened(measurement, contact, SMOOTH)
        prepared = prepare(few, own, noise)
    entries, absent = candidates_for(few, prepared.contact, names, own)
    if prepared.problem is None:
        return unknown_noise(measurement, prepared, entries)
    screening = {trial.name for trial in few.trials}
    seen = replace(whole, trials=tuple(trial for trial in whole.trials if trial.name in screening))
    read = unlike(read_impacts(seen, prepared.noise), few.trials[0].surroundings)

    all_rows = (on_all_rows(whole),) if whole is not measurement else ()

    def searched(prepared, entries, absent):
        search = Search(prepared.problem, entries, Folds(prepared.problem.trials, file.hold_out), say, read)
        return assemble(prepared, search, absent, judge, where_it_fails, *all_rows)

    found = searched(prepared, entries, absent)
    if few is many:
        return found
    say("fitting more recordings")
    kept = {*found.effects, *(name for members in found.ambiguous for name in members)}
    confirmed = searched(prepare(many, own, noise), [entry for entry in entries if entry.name in kept], {})
    others = tuple(
        replace(finding, why=f"on {len(few.trials)} recordings: {finding.why}")
        for finding in found.candidates
        if finding.effect not in kept
    )
    left_out = tuple(note for note in found.notes if note.startswith(LEFT_OUT) and note not in confirmed.notes)
    return replace(confirmed, candidates=confirmed.candidates + others, notes=(*notes, *confirmed.notes, *left_out))


def assemble(prepared, search, absent, judge, where, told=lambda problem, fit: (problem, fit)):
    """Run the search and put everything it found into a Diagnosis.

    judge: function (problem, fit) -> (Adequacy, table of observations); where: function (problem, table) -> rows;
    told: function (problem, fit) -> those whose verdict and numbers are told, where the search has fewer rows.
    """
    measurement, problem, base = prepared.measurement, prepared.problem, prepared.base
    verdict_before, table_before = judge(*told(problem, base))
    fits, rounds = submerged(search, *rerouted(search, *reformed(search, *search.run(base))))
    settled = len(fits[-1].model.terms) < 2 and not problem.shots.contact  # else a term may stand where another belongs
    if not settled:
        fits, rounds = exchanged(search, fits, rounds)
    final, exact = fits[-1], polished(problem, fits[-1])  # rivals were, and are, fitted at the step of the search
    judged, best = told(problem, exact)
    verdict_after, table_after = judge(judged, best)
    search.progress("rivals")
    others = rivals(search, final, 1.0 if verdict_after.adequate else max(verdict_after.chi2, 1.0))
    terms = final.model.terms
    effects = tuple(term.name for term in terms)
    sets = [tuple([term.name] + sorted(name for name, _, _ in rest)) for term, rest in zip(terms, others, strict=True)]
    ambiguous = tuple(members for members in sets if len(members) > 1)
    if not verdict_after.adequate:
        verdict = "unexplained"
    elif ambiguous:
        verdict = "ambiguous"
    else:
        verdict = "effect" if effects else "complete"
    unit = problem.unit
    error = _errors(search, base, exact, unit)
    steps, shown = [], []
    for fit in [*fits[:-1], exact]:
        names = [term.name for term in fit.model.terms]
        if names not in shown:
            shown.append(names)
            held, fitted = held_out_error(search, fit, unit), fitted_error(search, fit, unit)
            steps.append({"effects": names, "held_out": held, "fitted": fitted})
    findings = _findings(search, fits, rounds, others, effects, absent, unit, verdict_after)
    following = None
    if verdict in ("ambiguous", "unexplained"):
        following = experiment_design.next_experiment(prepared, search, final, others, verdict)
    adequate = {
        "before": verdict_before.adequate,
        "after": verdict_after.adequate,
        "statistic": verdict_after.statistic,
        "p": verdict_after.p,
        "threshold": verdict_after.threshold,
        "speaks": verdict_after.worst,
        "chi2_per_freedom": {"before": verdict_before.chi2, "after": verdict_after.chi2},
    }
    noise = {
        "position": prepared.noise.position,
        "orientation": prepared.noise.orientation,
        "rho": prepared.noise.rho,
        "source": prepared.noise.source,
        "flexible": prepared.noise.hint,
    }
    return Diagnosis(
        kind=measurement.file.kind,
        title=measurement.file.title,
        verdict=verdict,
        effects=effects,
        parameters=intervals(best, 1.0 if verdict_after.adequate else verdict_after.chi2),
        ambiguous=ambiguous,
        error=error,
        steps=tuple(steps),
        adequate=adequate,
        candidates=findings,
        where=where(judged, table_after),
        next_experiment=following,
        notes=(*prepared.notes, *search.budget.notes()),
        noise=noise,
        model=best.model,
        pictures={
            "before": table_before,
            "after": table_after,
            "trials": [trial.name for trial in problem.trials],
            "groups": [trial.group for trial in problem.trials],
            "kind": measurement.file.kind,
            "input": next(iter(problem.table.inputs), "row") if measurement.file.kind == "outcomes" else None,
        },
    )


def intervals(fit, inflation):
    """{effect: {name: value, low, high, unit}} at 90 %, widened where the model is not adequate, inside the bounds."""
    found, place = {}, 0
    quantile = stats.t.ppf(0.5 + INTERVAL / 2, fit.freedom)
    for term in fit.model.terms:
        numbers = {}
        for free in term.candidate.free:
            error = quantile * np.sqrt(max(inflation, 1.0) * max(fit.covariance[place, place], 0.0))
            value = fit.estimate[place]
            low, high = (-np.inf, np.inf) if free.period is not None else (min(free.low, value), max(free.high, value))
            numbers[free.name] = {
                "value": float(value),
                "low": float(max(value - error, low)),
                "high": float(min(value + error, high)),
                "unit": free.unit,
            }
            place += 1
        found[term.name] = numbers
    return found


def _rms(problem, residuals, unit):
    """RMS over positions [m] or rotations [rad] of residuals in units of sigma."""
    total, count = 0.0, 0
    for recording, part in zip(problem.recordings, residuals, strict=True):
        inside = recording.channel < 3 if unit != "rad" else recording.channel >= 3
        total += float(np.sum(part[inside] ** 2))
        count += int(inside.sum())
    sigma = problem.noise.orientation if unit == "rad" else problem.noise.position
    return float(sigma * np.sqrt(total / max(count, 1)))


def fitted_error(search, fit, unit):
    """RMS residual of a fit on the data it was fitted to."""
    r, s = fit.linear.projected
    return _rms(search.problem, search.coloured(r), unit)


def held_out_error(search, fit, unit):
    """RMS residual on recordings the numbers were not fitted to; None where nothing can be held out."""
    if not search.folds.possible:
        return None
    return _rms(search.problem, search.coloured(search.folds.residuals(fit)), unit)


def _errors(search, base, final, unit):
    noise = search.problem.noise.orientation if unit == "rad" else search.problem.noise.position
    held = None
    if search.folds.possible:
        held = {"before": held_out_error(search, base, unit), "after": held_out_error(search, final, unit), "noise": noise}
    return {
        "measure": "rms",
        "unit": unit,
        "held_out": held,
        "fitted": {"before": fitted_error(search, base, unit), "after": fitted_error(search, final, unit), "noise": noise},
    }


def _findings(search, fits, rounds, rivals, effects, absent, unit, adequacy):
    """One Finding a candidate: accepted ones first, then by evidence."""
    found = []
    partners = {name: (effect, cosine) for effect, others in zip(effects, rivals, strict=True) for name, _, cosine in others}
    for entry in search.candidates:
        name = entry.name
        trials = [trials[name] for trials in rounds if name in trials]
        refitted = [trial for trial in trials if trial.fit is not None]
        best = max(refitted, key=lambda trial: trial.gain, default=None)
        last = trials[-1] if trials else None
        accepted = name in effects
        if accepted and best is None:  # brought in with another one, not in a round of its own
            best = beside(search, fits[0], fits[-1], effects.index(name))
        same = tuple(sorted({other for members in _sets(effects, rivals) if name in members for other in members} - {name}))
        cosines = {}
        if name in partners:
            cosines = {partners[name][0]: round(partners[name][1], 4)}
        elif accepted:
            cosines = {other: round(cosine, 4) for other, _, cosine in rivals[effects.index(name)]}
        why = _why(name, accepted, same, best, last, effects, adequacy)
        if best is not None:
            fitted, held, gain = fitted_error(search, best.fit, unit), held_out_error(search, best.fit, unit), best.gain
        else:
            fitted, held, gain = None, None, last.linear_gain if last is not None and last.visible else None
        evidence = None if gain is None else float(gain - search.fee(entry))
        found.append(Finding(name, fitted, held, evidence, accepted, same, why, cosines, _visible(last)))
    found.sort(key=lambda entry: (not entry.accepted, -(entry.evidence if entry.evidence is not None else -1e9), entry.effect))
    found += [Finding(name, None, None, None, False, (), f"not tried: {why}") for name, why in sorted(absent.items())]
    return tuple(found)


def _sets(effects, rivals):
    return [[effect] + [name for name, _, _ in others] for effect, others in zip(effects, rivals, strict=True)]


def _why(name, accepted, same, best, last, effects, adequacy):
    """One sentence on a candidate."""
    form = set_of(name)
    if accepted:
        text = f"accepted: chi2 falls by {best.gain:.0f} for a price of {best.price:.0f}"
        if best.directions:
            text += "; held-out error falls by " + " and ".join(f"{100 * fall:.0f} %" for fall in best.directions)
        return text + (f"; cannot be told from {', '.join(same)}" if same else "")
    if same:
        label = f" ({form})" if form and any(set_of(other) == form for other in same) else ""
        return f"does as well as {', '.join(other for other in same if other in effects)}: not to be told apart here{label}"
    better = [other for other in effects if form and set_of(other) == form]
    if best is not None and better:
        return f"of one set ({form}) with {better[0]}, which explains the data better"
    if last is not None and last.fit is not None and last.gain > last.price and last.fails:
        return "suspected: " + "; ".join(last.fails)
    if last is None or not last.visible:
        return "cannot be seen in these data: what it does is absorbed by the unknown start or by what is in the model"
    if best is not None and best.gain > best.price and not best.fails:
        return "explained the residual too, less well than what was accepted"
    if best is not None and best.gain > best.price:
        return "pointed at the residual before the rest was explained: " + "; ".join(best.fails)
    return f"not seen: chi2 would fall by {max(last.linear_gain, 0.0):.1f}, less than the price of {last.price:.1f}"


def _visible(last):
    """The smallest value of a one-number candidate these data would have shown nine times in ten."""
    if last is None or not last.visible or len(last.candidate.free) != 1 or last.candidate.absent is None:
        return ""
    free = last.candidate.free[0]
    size = (np.sqrt(last.price) + 1.28) / last.visible
    return f"{free.name} {size:.2g}{'' if free.unit == '1' else ' ' + free.unit} from {free.null:g}"


def unknown_noise(measurement, prepared, entries):
    """The verdict cannot_judge, with what to record."""
    hint = prepared.noise.hint
    text = (
        "record the tracker looking at a body at rest (measurement.static), or repeat a trial from the same start, or state "
        "measurement.noise"
    )
    if measurement.file.kind == "outcomes":
        text = "repeat some rows with equal inputs (replicates), or state measurement.noise"
    if hint:
        text += f"; a flexible curve through the data leaves {hint:.2g} m (rho {prepared.noise.rho:.2f}): a hint, no more"
    return Diagnosis(
        kind=measurement.file.kind,
        title=measurement.file.title,
        verdict="cannot_judge",
        effects=(),
        parameters={},
        ambiguous=(),
        error={"measure": "rms", "unit": None, "fitted": None, "held_out": None},
        steps=(),
        adequate={"before": None, "after": None, "statistic": None, "p": None},
        candidates=tuple(
            Finding(entry.name, None, None, None, False, (), "not judged: the noise is unknown") for entry in entries
        ),
        where=(),
        next_experiment=experiment_design.NextExperiment(text, (), None, {}),
        notes=prepared.notes,
        noise={"position": None, "source": "unknown", "flexible": hint},
    )

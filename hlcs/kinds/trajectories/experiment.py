"""Recordings as a kind of measurement: read, compared with the model under test, searched for what it is missing."""

from collections import Counter
from dataclasses import replace
from functools import cached_property, partial
from itertools import combinations

import numpy as np

from hlcs.data.experiment_file import LAYOUTS
from hlcs.data.impacts import read_drags, read_impacts
from hlcs.data.notes import OutOfTime, Stopped
from hlcs.data.quantities import CHANNEL_UNITS, CHANNELS, have_unit
from hlcs.data.recordings import read_recordings
from hlcs.data.shown_by_impacts import differing_from_model, rebounds_shown, reliable
from hlcs.effects import check_names, class_named
from hlcs.effects.needs_of_model import check_needs
from hlcs.estimation.budget import SMOOTH_LIMIT, only, screening_subset
from hlcs.estimation.cross_validation import FEW_RECORDINGS, CrossValidation
from hlcs.estimation.noise_model import estimate_noise, shown_by_curves
from hlcs.estimation.segments import lost_notes
from hlcs.kinds.noise_shown import Shown, noise_shown
from hlcs.kinds.protocol import Observation, misfit
from hlcs.kinds.trajectories.contact_numbers import numbers_at
from hlcs.kinds.trajectories.observations import judge, recordings_of, where_it_fails
from hlcs.kinds.trajectories.preparation import beside, prepare, starts_seated, touches, without
from hlcs.kinds.trajectories.release import let_go
from hlcs.kinds.trajectories.sinking import drags_between_impacts, drags_shown
from hlcs.kinds.trajectories.spinning import spin_losses_shown
from hlcs.kinds.trajectories.stated_starts import starts_shown
from hlcs.kinds.trajectories.thinning import on_all_rows, thinned
from hlcs.kinds.trajectories.time_step import alone, misfit_by_step, polished, polisher, with_step_error
from hlcs.learning import learn, learn_rebounds
from hlcs.records import Reason
from hlcs.rendering import Pictures
from hlcs.selection.eligibility import candidates_for, fastest
from hlcs.selection.planning import Pilot
from hlcs.selection.renewal import affordable, due, renewed
from hlcs.selection.search import Search
from hlcs.selection.thresholds import ODDS, ODDS_ALONE
from hlcs.selection.verdict import select
from hlcs.simulation.model import Term

LOOKS = 2  # for samples that stand alone, while a search goes on, and as many at its end: more change nothing that is noticed


def terms_shown(candidates, shown):
    """[terms] of each candidate that impacts point to, alone and with each that can stand beside it; shown: {name: numbers}."""
    terms = [Term(entry, tuple((entry.start | shown[entry.name]).items())) for entry in candidates if entry.name in shown]
    pairs = [pair for pair in combinations(terms, 2) if len({term.candidate.alike or term.name for term in pair}) == 2]
    return [*((term,) for term in terms), *pairs]


def numbers_found(selection, candidates):
    """[{effect: {number: value}}] of the sets of effects that a Selection tells, the best first; those not shown as expected."""
    expected = {candidate.name: candidate.expected for candidate in candidates}

    def whole(name, shown):
        return {key: value if shown.get(key) is None else shown[key] for key, value in expected[name].items()}

    told = (members["parameters"] for members in selection.sets if members["effects"])
    return [{name: whole(name, shown) for name, shown in numbers.items()} for numbers in told]


def on_fewer(finding, count):
    """A Finding of a search on so many of the recordings; what was not tried there was not tried at all."""
    if finding.reason is Reason.NOT_TRIED:
        return finding
    return replace(finding, **Reason.ON_FEWER_RECORDINGS(count=count, why=finding.why)._asdict())


class Trajectories:
    """An OpenExperiment (`kinds.protocol`) of recordings: the pose of one body at many times, in one or more trials."""

    kind, measure, unit, carried_noise, shows_motion = "trajectory", "rms", "m", False, True
    layout = LAYOUTS[kind]
    unjudged = Reason.NOT_JUDGED()
    judge, where = staticmethod(judge), staticmethod(where_it_fails)
    alone, polisher, with_step_error = staticmethod(alone), staticmethod(polisher), staticmethod(with_step_error)
    polished_notes = staticmethod(lost_notes)
    starts_shown = staticmethod(partial(starts_shown, judge=judge))

    def __init__(self, file, options):
        said = check_names(file, options.user_effects)  # a misspelt candidate is the user's to mend, though comparing tries none
        check_needs(file, options.user_effects, file.trials)
        self.options, self.title, self.tolerance = options, file.title, file.tolerance
        measurement = read_recordings(file)
        self.measurement = replace(measurement, notes=(*said, *measurement.notes))
        options.log("fitting the model under test")
        noise = self._noise = estimate_noise(self.measurement)
        self.measurement = let_go(self.measurement, noise, [starts_seated(trial, noise) for trial in measurement.trials])
        self.notes = (*self.measurement.notes, *self._noise.notes)

    @cached_property
    def _impacts(self):
        """What impacts show without the model, [Impact]."""
        return read_impacts(self.measurement, self._noise)

    @cached_property
    def _contact(self):
        """Does anything touch?"""
        return touches(self.measurement.trials, self._noise)

    @property
    def judgeable(self):
        return self._noise.known

    @property
    def noise(self):
        return self._noise.to_dict()

    @property
    def advice(self):
        advice = (
            "record the tracker looking at a body at rest (measurement.static), or repeat a trial from the same start, or state "
            "measurement.noise"
        )
        if hint := self._noise.hint:
            advice += f"; a flexible curve through the data leaves {1000 * hint:.2g} mm: a hint, no more"
        return advice

    def observe(self, aside=()):
        prepared = prepare(self.measurement, self.options.user_effects, self._noise)
        prepared = without(prepared, aside) if aside else prepared
        adequacy, table = judge(prepared.problem, prepared.base)
        unit = prepared.problem.unit
        impacts = self._impacts
        error = misfit(table["residual"][have_unit(table["channel"], unit)], unit, prepared.problem.noise_level)
        shown = {
            "trials": tuple(trial.name for trial in prepared.problem.trials),
            "channels": CHANNELS,
            "against": ("time", "height", "speed"),
            "impacts": impacts,
            "at_impacts": numbers_at(impacts, prepared.base.model, self.measurement.trials),
        }
        if not adequacy.adequate:
            shown["starts_shown"] = self.starts_shown(prepared.problem, prepared.base)
            shown["noise_shown"] = None if shown["starts_shown"] else self.noise_shown(prepared.problem, prepared.base)
        where = where_it_fails(prepared.problem, table)
        notes, flags = (*prepared.notes, *prepared.aside), tuple(prepared.problem.dropped)
        return Observation(adequacy.adequate, adequacy.statistic, adequacy.p, error, where, table, notes, shown, flags)

    def noise_shown(self, problem, fit):
        """What smooth curves through the recordings leave, where the model would be adequate with it (`kinds.noise_shown`)."""
        found = shown_by_curves(self.measurement, self._noise)
        if found is None:
            return None
        what, unit, noise = found
        seen = "smooth curves through the recordings leave"
        at_rest = "record a body at rest, name it under measurement.static, and leave measurement.noise out: it tells the noise"
        shown = Shown(what, noise.of_unit(unit), unit, seen, noise, at_rest)
        return noise_shown(problem, fit, shown, judge, self.measurement.file)

    def learn(self, problem, fit, best):
        """The Learned law that explains what a fit leaves, of rebounds or of a force, or None; best: Fit of the best effects."""
        whole = problem.contact and not problem.segmented
        readings = reliable(self._impacts, "restitution") if whole else []
        return learn_rebounds(problem, fit, best, readings, polished, self.measurement.file.hold_out) or learn(problem, fit)

    @staticmethod
    def moved(problem):
        """[(body, surroundings, highest speed)] of the recordings, as `selection.reynolds.reached` asks for it."""
        return [(trial.body, trial.surroundings, fastest(trial)) for trial in problem.trials]

    def names(self, candidates):
        return tuple(candidate.name for candidate in self._candidates(self.measurement, self._contact, candidates)[0])

    def _candidates(self, measurement, contact, names):
        seated = [contact and starts_seated(trial, self._noise) for trial in measurement.trials]
        return candidates_for(measurement, contact, names, self.options.user_effects, seated)

    def search(self, candidates):
        noise, own = self._noise, self.options.user_effects
        contact, measurement = self._contact, thinned(self.measurement, noise)
        read, around = self._impacts, measurement.trials[0].surroundings
        impacts = differing_from_model(read, around)
        likely = terms_shown(self._candidates(measurement, contact, candidates)[0], impacts)
        few, many, notes = screening_subset(measurement, contact)
        prepared = prepare(few, own, noise, likely)
        if few is not many and prepared.problem.segmented:
            few, many, notes = only(few, measurement)
        elif few is not many:  # cheaper than feared
            few, many, notes = screening_subset(measurement, contact, SMOOTH_LIMIT, prepared.problem.simulator.time_step)
            prepared = prepare(few, own, noise, likely)
        contact = prepared.problem.contact  # of these few
        chosen, absent = self._candidates(few, contact, candidates)
        strong = {} if contact else drags_shown(chosen, few.trials)
        bent = drags_between_impacts(chosen, few.trials, read_drags(self.measurement, noise), read) if contact else {}
        together = rebounds_shown(read, around, bent)
        strong |= {} if prepared.problem.segmented else spin_losses_shown(chosen, few.trials, contact)
        on_all = {"on_all": on_all_rows(self.measurement)} if measurement is not self.measurement else {}

        def searched(prepared, chosen, absent, found=()):
            cross_validation = CrossValidation(prepared.problem.trials, measurement.file.hold_out)
            odds = ODDS if cross_validation.possible else ODDS_ALONE
            few_fits = prepared.problem.segmented  # are affordable: where the impacts point to, and where a look ended
            guess = prepared.problem.initial_guess()
            shown = [(impacts, None), *([] if few_fits else [(strong, guess)])]
            first = [({entry.name: seen[entry.name]}, at) for seen, at in shown for entry in chosen if entry.name in seen]
            names = {entry.name for entry in chosen}
            first += [(numbers, None) for numbers in together if numbers.keys() <= names]
            first = [(numbers, None) for numbers in found] or first
            begun = partial(Search, prepared.problem, chosen, odds=odds, progress=self.options.log, readings=impacts | strong)
            search, looked = begun(base=prepared.base, first=first), [frozenset()]

            def pause(best, promised):
                by_step = partial(misfit_by_step, search.problem)
                return not few_fits and len(looked) <= LOOKS and due(search, looked, best, promised, by_step)

            while (best := search.run(pause).ranked()[0]) not in looked and len(looked) <= 2 * LOOKS:
                if search.budget.stopped or few_fits and not affordable(search):
                    break
                looked.append(best)
                prepared, search = self._beside(prepared, search, best, begun)
                if search.budget.stopped:
                    break
            return select(self, prepared, search, cross_validation, absent, **on_all)

        first = searched(prepared, chosen, absent)
        if few is many or Stopped.among(first.notes):
            return replace(first, notes=(*notes, *first.notes))
        self.options.log("fitting more recordings")
        found = numbers_found(first, chosen)
        names = set().union(*found)
        kept = [candidate for candidate in chosen if candidate.name in names]
        confirmed = searched(prepare(many, own, noise, likely), kept, {}, found)
        others = tuple(on_fewer(each, len(few.trials)) for each in first.candidates if each.effect not in names)
        left_out = (note for note in OutOfTime.among(first.notes) if note not in confirmed.notes)
        return replace(confirmed, candidates=confirmed.candidates + others, notes=(*notes, *confirmed.notes, *left_out))

    def _beside(self, prepared, search, best, begun):
        """(Prepared, Search) that go on beside a fit (`preparation.beside`): the same where it shows nothing new of the data, and
        where Ctrl-C comes, since what is fitted so far is of the data as they were."""
        problem = prepared.problem
        known = problem.dropped, problem.step_change, problem.simulator.time_step
        try:
            if other := beside(prepared, search.fits[best]):
                after = renewed(search, partial(begun, base=other.base, budget=search.budget))
                after.expand()
                return other, after
        except KeyboardInterrupt:
            problem.leave_out(known[0])
            problem.step_change, problem.simulator.time_step = known[1:]
            search.budget.stop(self.options.log)
        return prepared, search

    def pilot(self, effect):
        class_named(effect, self.options.user_effects)
        names = self.measurement.file.candidates
        candidates, absent = self._candidates(self.measurement, self._contact, None if names is None else [*names, effect])
        cross_validation = CrossValidation(self.measurement.trials, self.measurement.file.hold_out)
        bodies = Counter(trial.body for trial in self.measurement.trials)
        count = len(self.measurement.trials)
        prepared = partial(prepare, self.measurement, self.options.user_effects, self._noise)
        few_below = FEW_RECORDINGS * count / min(bodies.values())
        return Pilot(candidates, absent, prepared, cross_validation.possible, few_below, count)

    @staticmethod
    def pictures(problem, before, after):
        """What the figure of a Diagnosis draws, segments as the recordings that they are parts of."""
        names = tuple(recordings_of(problem))
        before, after = (table | {"trial": table["recording"]} for table in (before, after))
        return Pictures(before, after, names, "time", "time [s]", CHANNELS, tuple(np.repeat(CHANNEL_UNITS, 3).tolist()))

"""What these data cannot tell apart, and the experiment that would.

A and B are two sets of effects that do as well, with their fitted numbers. Of N tests Lambda(N) = min over what stays unknown of
|y_A - y_B|^2 in units of the noise, the smaller of the two where either may be wrong. The difference of two costs moves by Lambda
with standard deviation 2 sqrt(Lambda): the right one wins by more than 6 units with probability 0.9 when Lambda(N) >= 16.4,
and from behind when it is larger (`separation_for`; T-optimal design: Atkinson and Fedorov, Biometrika 62 (1975) 57). Unknown are
the start of each test, which is its own, and the numbers of the wrong one, which all tests share and which move as far as the
present data let them: more tests of one kind may tell no more at all.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from hlcs.effects import classes
from hlcs.estimation.designs import Design
from hlcs.estimation.least_squares import project_out
from hlcs.records import NextExperiment
from hlcs.selection.eligibility import to_be_given
from hlcs.selection.thresholds import TIED

NINE_IN_TEN = 1.2816  # of the normal distribution at 0.9
MOST_TESTS = 1000  # that anybody makes
FORETOLD = 10**8  # tests up to which it is said how much sharper they would have to be
SOME_TESTS = 100  # that a laboratory makes with another tracker, where it would take more than MOST_TESTS


class Option(NamedTuple):
    """One experiment for one pair of explanations."""

    tests: int | None  # None = no number of them tells the two apart
    score: float  # lambda: separation of that many tests, for each
    text: str
    design: dict
    far: float = 0.0  # octaves from what was measured
    direct: bool = False  # a suspect itself is measured
    shows_both: str = ""  # where no number of tests will do: a direct reading that shows either suspect, and not which

    @property
    def effort(self):
        """What it costs: tests, dearer the further they are from what has been set up."""
        return (self.tests or np.inf) * (1 + self.far**2), not self.direct, self.text


def separation_for(behind):
    """Lambda with which the right one wins by more than TIED with probability 0.9, behind by some units of cost as it may be."""
    return float((NINE_IN_TEN + np.sqrt(NINE_IN_TEN**2 + TIED + behind)) ** 2)


SEPARATION = separation_for(0.0)  # 16.4


def tests_needed(separation, wanted=SEPARATION):
    """N = ceil(16.4 / lambda), None where a thousand tests do not separate."""
    return max(int(np.ceil(wanted / separation)), 1) if separation * MOST_TESTS >= wanted else None


def feasible(option):
    """Would a laboratory make so many tests?"""
    return bool(option.tests) and option.tests <= MOST_TESTS


def next_experiment(sets, absent, verdict):
    """The experiment that best separates the best set from those that do as well, or finds out what stays unexplained; beside a
    number beyond what is plausible, what an effect needs that could not be tried. None where no question is open.

    absent: {name: why it was not tried}."""
    problem, fits = sets.search.problem, sets.search.fits
    final, found = fits[sets.best], []
    if verdict not in ("ambiguous", "unexplained"):
        more = to_be_given(absent) if final.implausible else ""
        return NextExperiment(more, (), None) if more else None
    for effects in sets.tied[1:]:
        names = _named(sets.best - effects), _named(effects - sets.best)
        terms = [
            term
            for fit, rest in ((final, effects), (fits[effects], sets.best))
            for term in fit.model.terms
            if term.name not in rest
        ]
        wanted = separation_for(abs(sets.cost(effects) - sets.cost(sets.best)))
        options = witnesses(problem, terms, wanted)
        if not any(option.tests == 1 for option in options):  # nothing costs less
            options += designs(problem, final, fits[effects], wanted)
        if options:
            best = min(options, key=lambda option: option.effort)
            found.append(
                (best.score, names, best if feasible(best) else best._replace(shows_both=reading_of_all(problem, terms)))
            )
    if not found:
        return unexplained(problem, final, absent)
    within_reach = [entry for entry in found if feasible(entry[2])]
    _, names, best = min(within_reach or found, key=lambda entry: entry[:2])  # of the pair that is hardest to separate
    others = [entry for entry in found if entry[1] != names]
    sentence = _told(best, names) + "".join(f"; against {entry}" for entry in _told_of_others(best, others)[:3])
    separates = tuple(name for part in names for name in part.split(" + ") if name != NOTHING)
    needed = best.tests if feasible(best) else None
    if verdict == "unexplained":
        return unexplained(problem, final, absent, separates, sentence, needed, best.design if best.tests else None)
    more = to_be_given({name: why for name, why in absent.items() if _alike(name) in {*map(_alike, separates)} - {""}})
    return NextExperiment("; ".join(filter(None, (sentence, more))), separates, needed, best.design if best.tests else {})


def _alike(name):
    """The label of the effects that may turn out to be one and the same as that of this name; "" where it has none."""
    return getattr(classes().get(name), "alike", "")


NOTHING = "no effect"


def _named(effects):
    return " + ".join(sorted(effects)) or NOTHING


def _told(option, names):
    """What to do, how many tests of it tell two explanations apart, and what would help where no laboratory makes so many."""
    tests, pair = option.tests, f"{names[0]} from {names[1]}"
    if feasible(option):
        return f"{option.text} ({tests} test{'' if tests == 1 else 's'} to tell {pair})"
    directly = "measure what one of them is about directly, or over a range wider than four times this one"
    if option.shows_both:
        return f"no {MOST_TESTS:,} tests with this set-up tell {pair}; one reading shows either: {option.shows_both}"
    if not tests:  # none of the experiments is any better than the others
        return f"no {MOST_TESTS:,} tests with this set-up tell {pair}: {directly}"
    sharper = f"with noise {np.sqrt(tests / SOME_TESTS):.2g} times smaller {SOME_TESTS} tests would"
    return (
        f"{option.text} would be best, but no {MOST_TESTS:,} tests with this set-up tell {pair}: {sharper}; otherwise {directly}"
    )


def _told_of_others(best, others):
    """What else tells the other pairs, of [(lambda, names, Option)]: another experiment, or none."""
    rivals = {}  # what is to be done -> against which sets
    for _, names, each in others:
        if feasible(each) and each.text != best.text:
            rivals.setdefault(each.text, set()).add(names[1])
    told = [f"{' or '.join(sorted(names))}: {text}" for text, names in rivals.items()]
    beyond = {f"{names[1]} no {MOST_TESTS:,} tests with this set-up would do" for _, names, each in others if not feasible(each)}
    return sorted(told) + (sorted(beyond) if feasible(best) else [])


def unexplained(problem, fit, absent, names=(), more="", needed=None, design=None):
    """What to do where the model fails and no candidate mends it: look again where it misses most, and give what candidates that
    were not tried need."""
    place, again = problem.worst(fit)
    told_apart = f"what comes back is {problem.subject}, what does not is the measurement"
    how = ", in another order and by other hands" if len(problem.trials) > 1 else ", by other hands"
    told = [f"repeat {place}{how}: {told_apart}", *[f"then: {more}"] * bool(more), *filter(None, [to_be_given(absent)])]
    return NextExperiment("; ".join(told), names, needed, design or again)


# --- direct witnesses: measure the suspect itself ----------------------------------------------------------------------


def witnesses(problem, terms, wanted):
    """[Option]: direct readings of effects that two explanations do not share.

    None of a law tells two forms of it apart. One that shows two suspects alike tells neither: a spirit level leans on a floor
    that slopes and where gravity leans.
    """
    forms = [term.candidate.form_of for term in terms if term.candidate.form_of]
    told_apart = [term for term in terms if forms.count(term.candidate.form_of) < 2]
    readings = [(term.name, *reading) for term in told_apart if (reading := problem.reading(term))]
    found = [Option(tests_needed(score, wanted), score, text, {"witness": name}, direct=True) for name, text, score in readings]
    said = [option.text for option in found]
    return [option for option in found if option.tests and said.count(option.text) == 1]


def reading_of_all(problem, terms):
    """The direct reading that shows each of these effects alike, "" where there is none."""
    said = {(problem.reading(term) or ("", 0.0))[0] for term in terms}
    return said.pop() if len(terms) > 1 and len(said) == 1 else ""


# --- designs: more tests, of one kind or of two in equal parts ---------------------------------------------------------


class Part(NamedTuple):
    """What one test says if B is wrong, of its numbers in units of their present uncertainty:
    Lambda(N) = N a - N^2 b'(1 + N c)^-1 b."""

    a: float
    b: np.ndarray  # (p,)
    c: np.ndarray  # (p, p)

    def with_another(self, other):
        """Both of two tests."""
        return Part(*(x + y for x, y in zip(self, other, strict=True)))

    def separation(self):
        """Lambda as a function of N."""
        values, vectors = np.linalg.eigh(self.c)
        b2, values = (vectors.T @ self.b) ** 2, np.maximum(values, 0.0)
        return lambda n: n * self.a - n**2 * float(np.sum(b2 / (1 + n * values)))


def option(design, parts, wanted, each=1):
    """The Option of a design with as many tests as separate, `each` at a time, whichever explanation is wrong; None of them where
    none below FORETOLD do. parts: a Part for either."""
    ways = [part.separation() for part in parts]

    def separation(n):
        return min(way(n) for way in ways)

    low, high = 0, 1
    while separation(high) < wanted and high < FORETOLD:
        low, high = high, 2 * high
    if separation(high) < wanted:
        return Option(None, 0.0, design.lead + design.text, design.what, design.far)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if separation(middle) >= wanted else (middle, high)
    return Option(each * high, separation(high) / (each * high), design.lead + design.text, design.what, design.far)


def designs(problem, final, other, wanted):
    """[Option] of what the kind of measurement can do next, simulated under both explanations."""
    new = problem.designs(final, other)
    if not new.options:
        return []
    known = [
        each for each in zip(new.options, parts(new, final, other), strict=True) if np.isfinite([one.a for one in each[1]]).all()
    ]
    found = [option(design, both_wrong, wanted) for design, both_wrong in known]
    for (one, first), (two, second) in combinations(known, 2):
        if what := both(one, two):
            design = Design(f"{one.text} and {two.text}, half of them each", what, max(one.far, two.far), one.lead)
            found.append(option(design, [x.with_another(y) for x, y in zip(first, second, strict=True)], wanted, each=2))
    return found


def both(one, two):
    """{input: [value, value]} of two designs that differ in one input, with what they share; else None."""
    differing = [key for key in one.what if one.what[key] != two.what.get(key)]
    if set(one.what) != set(two.what) or len(differing) != 1:
        return None
    return one.what | {differing[0]: [one.what[differing[0]], two.what[differing[0]]]}


def parts(new, final, other):
    """[(Part if the second is wrong, Part if the first is)] of each design: what stays of the difference of two fits once the
    start of the test is free."""
    with np.errstate(all="ignore"):
        mine, theirs = (new.problem.linearise(fit.model, new.initial_states) for fit in (final, other))
    both_ways = []
    for fit, wrong, right in ((other, theirs, mine), (final, mine, theirs)):
        root, found = _root(fit), []
        apart = new.problem.whitened([a - b for a, b in zip(wrong.raw, right.raw, strict=True)])
        for k, difference in enumerate(apart):
            rest = project_out(wrong.state_bases[k], difference)
            s = project_out(wrong.state_bases[k], wrong.parameter_columns[k]) @ root
            if new.shared:
                s = np.hstack([s, new.shared[k]])
            found.append(Part(float(rest @ rest + 0.0 * s.sum()), s.T @ rest, s.T @ s))  # not finite where either is not
        both_ways.append(found)
    return list(zip(*both_ways, strict=True))


def _root(fit):
    """R with R R' = the covariance of the numbers of a fit (p, p)."""
    values, vectors = np.linalg.eigh(fit.covariance / np.outer(fit.errors, fit.errors))
    return fit.errors[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))

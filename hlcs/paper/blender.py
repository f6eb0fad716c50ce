"""Our layers beside those of Blender and pybullet at Blender's settings, and our defaults beside the laboratory, with many seeds.

At the first, z says of every layer whether two programs differ by more than both means are uncertain by; each further row
changes one step of the procedure, so that a difference can be traced. At the second, the error has an interval over seeds, and
beside it stands what a perfect model would show, as the laboratory's own means are uncertain.
"""

import numpy as np

from hlcs.kinds.layers.model import PlacementSimulator
from hlcs.paper import reproduce
from hlcs.paper.workability import with_interval
from hlcs.placement import statistics
from hlcs.placement.comparison import repeated
from hlcs.placement.number_text import or_dash, percent
from hlcs.placement.printed_tables import laboratory, reference_runs
from minibullet.errors import InputError

SEEDS = 20
BLENDER = {"friction": 0.36, "margin": 0.008, "plate_margin": 0.008, "time_step": 1.0 / 60.0, "iterations": 10}
BLENDER_ERROR = 0.01  # standard error of a mean of five tests of Blender or pybullet, any layer [Dn]; docs/errata.md
PIECES, HARDLY, PYBULLET = "Blender, seven pieces", "Blender, pieces, nearly no margin", "pybullet, seven pieces"
LARGEST = 2.5  # |z| that is taken for chance
FINE = {"time_step": 1.0 / 240.0, "iterations": 50}
THIN = {"margin": 0.0012, "plate_margin": 0.0012}  # of that run
CASES = (  # grid, run of printed/reference.csv, which step of the procedure is changed, to what
    ("TPG", PIECES, "as Blender was run", {}),
    ("TPG", PIECES, "crowded units lifted", {"crowding": "lift"}),
    ("TPG", PIECES, "240 steps/s, 50 iterations", FINE),
    ("TPG", PIECES, "Bullet's solver", {"solver": "sequential_impulse"}),
    ("TPG", PIECES, "headings of layer 1 along x", {"yaw_constraint": 1e6}),
    ("TPG", PIECES, "contact friction 0.25", {"friction": 0.25}),
    ("TPG", HARDLY, "as Blender was run", THIN),
    ("TPG", HARDLY, "240 steps/s, 50 iterations", {**THIN, **FINE}),
    ("TPG", PYBULLET, "as Blender was run", {}),
    ("RPG", PIECES, "as Blender was run", {}),
    ("RPG", PIECES, "crowded units lifted", {"crowding": "lift"}),
    ("RPG", PIECES, "240 steps/s, 50 iterations", FINE),
    ("RPG", PYBULLET, "as Blender was run", {}),
    ("RPG", PYBULLET, "crowded units lifted", {"crowding": "lift"}),
)
CAMPAIGNS = (("table2", "TPG", "flat"), ("table2", "RPG", "flat"), ("table3", "TPG", "slope:0.04"))
WIDTH = 39  # of the words of a row
RESAMPLES = 10_000  # of the seeds, for the interval of an error


def blender(plan, progress=False, simulator=None):
    """The document: "beside_engines", one row for each of CASES, and "beside_laboratory", one for each of CAMPAIGNS.

    plan: `reproduce.Plan`; of its settings rows, columns and layers (at most 5) count, others are refused by InputError as every
    case has its own; progress: show a bar; simulator: of `hlcs.kinds.layers`, whose store pays every run once.
    """
    given = sorted(set(plan.settings) - set(reproduce.SIZE)) + ["preset"] * (plan.preset is not None)
    if given:
        raise InputError(f"reproduce blender: every case has its own settings; leave out --{', --'.join(given)}")
    if plan.test().layers > 5:
        raise InputError(
            f"reproduce blender: layers = {plan.test().layers}; the other engines placed 5, so give at most --layers 5"
        )
    seeds = list(range(plan.seed, plan.seed + (plan.repeats or SEEDS)))
    simulator = simulator or PlacementSimulator(workers=plan.workers, progress=progress)
    tests = [plan.test(grid=grid, **{**BLENDER, **change}) for grid, _, _, change in CASES]
    tests += [plan.test(grid=grid, bottom=bottom) for _, grid, bottom in CAMPAIGNS]
    runs = _coefficients(simulator, tests, seeds)
    return {
        "format": 1,
        "table": "blender",
        "repeats": len(seeds),
        "seeds": seeds,
        "beside_engines": [_beside_engines(*case, own) for case, own in zip(CASES, runs, strict=False)],
        "beside_laboratory": [_beside_laboratory(*c, own) for c, own in zip(CAMPAIGNS, runs[len(CASES) :], strict=True)],
        "versions": reproduce.versions(),
    }


def _coefficients(simulator, tests, seeds):
    """Layer coefficients (runs that stand, M) of each test with these seeds; InputError where fewer than two of a test stand."""
    every = simulator([reproduce.replace(test, seed=seed) for test in tests for seed in seeds])
    found = []
    for number, test in enumerate(tests):
        own = [k for k in every[number * len(seeds) : (number + 1) * len(seeds)] if k is not None and np.isfinite(k).all()]
        if len(own) < 2:
            raise InputError(
                f"reproduce blender: {len(own)} of {len(seeds)} structures on {test.grid.name} stand; take --repeats 2 or more"
            )
        found.append(np.array(own))
    return found


def _beside_engines(grid, run, changed, change, k):
    """k (n, M) beside another engine's run: the difference of the means over its standard error, layer by layer."""
    theirs = next(each for each in reference_runs("table2", grid) if each["run"] == run)
    own, layers = repeated(k), k.shape[1]
    measured = np.array(theirs["layers"][:layers])
    error = np.hypot(statistics.standard_error(own), BLENDER_ERROR)
    difference = own.mean - measured
    return {
        "grid": grid,
        "changed": changed,
        "settings": {**BLENDER, **change},
        "run": run,
        "tests": len(k),
        "k": own.mean.tolist(),
        "k_error": statistics.standard_error(own).tolist(),
        "theirs": measured.tolist(),
        "z": (difference / error).tolist(),
        "bias": reproduce.interval((k - measured).mean(axis=1)),
    }


def _beside_laboratory(table, grid, bottom, k):
    """k (n, M) beside a campaign: eps_R of the mean with its interval over the runs, and of a perfect model."""
    measured = laboratory(table, grid=grid)
    cut = statistics.Sample(*(part[: k.shape[1]] for part in (measured.mean, measured.cv, measured.tests)))
    generator = np.random.default_rng(0)
    drawn = k[generator.integers(len(k), size=(RESAMPLES, len(k)))].mean(axis=1)
    errors = np.mean(np.abs(drawn - cut.mean) / cut.mean, axis=1)
    low, high = np.quantile(errors, (0.025, 0.975))
    perfect = statistics.perfect_model_error(cut, repeated(k))
    return {
        "table": table,
        "grid": grid,
        "bottom": bottom,
        "tests": len(k),
        "k": k.mean(axis=0).tolist(),
        "error": {"mean": statistics.mean_relative_error(cut.mean, k.mean(axis=0)), "low": float(low), "high": float(high)},
        "single_test": reproduce.interval(np.mean(np.abs(k - cut.mean) / cut.mean, axis=1)),
        "bias": reproduce.interval(np.mean((k - cut.mean) / cut.mean, axis=1)),
        "perfect": {"mean": perfect.mean, "below_in_95_of_100": perfect.quantile, "p": perfect.p},
    }


def blender_text(document):
    """What `hlcs reproduce blender` prints."""
    layers = len(document["beside_engines"][0]["k"])
    numbers = range(1, layers + 1)
    lines = [
        f"Ours beside Blender 4.5 and pybullet 3.2.7 at Blender's settings, {document['repeats']} seeds: k, z of the difference",
        f"{'':{WIDTH}}"
        + "".join(f"{f'k{j}':>7}" for j in numbers)
        + "  "
        + "".join(f"{f'z{j}':>6}" for j in numbers)
        + f"{'ours less theirs [Dn]':>27}",
    ]
    run = None
    for row in document["beside_engines"]:
        if (row["grid"], row["run"]) != run:
            run = row["grid"], row["run"]
            lines.append(f"{', '.join(run):{WIDTH}}" + "".join(f"{k:>7.3f}" for k in row["theirs"]))
        far = "  larger" if np.abs(row["z"]).max() > LARGEST else ""
        cells = "".join(f"{k:>7.3f}" for k in row["k"]) + "  " + "".join(f"{z:>+6.1f}" for z in row["z"])
        lines.append(f"{'  ' + row['changed']:{WIDTH}}{cells}{with_interval(row['bias'], '+.3f'):>27}{far}")
    lines += [
        f"z: over the root of the variances of our mean and of theirs ({BLENDER_ERROR:g} Dn); larger: a layer beyond {LARGEST:g}",
        "",
        "Our defaults beside the laboratory, the same seeds: eps_R of the mean of all [95 % interval over seeds, bootstrap]; %",
        f"{'':14}{'eps_R %':>21}{'of a single test':>21}{'bias %':>23}   a perfect model: mean, 95 of 100 below, p",
    ]
    for row in document["beside_laboratory"]:
        perfect, hundred = (
            row["perfect"],
            [{name: 100.0 * v for name, v in row[key].items()} for key in ("error", "single_test", "bias")],
        )
        cells = (
            f"{with_interval(hundred[0], '.2f'):>21}{with_interval(hundred[1], '.2f'):>21}{with_interval(hundred[2], '+.2f'):>23}"
        )
        floor = f"{percent(perfect['mean'])}, {percent(perfect['below_in_95_of_100'])}, {or_dash(perfect['p'], '.3f')}"
        lines.append(f"{row['grid'] + ', ' + row['bottom']:14}{cells}   {floor}")
    return "\n".join(lines)

"""Table 1 judged: what each parameter does to the error, and whether that is more than the scatter between seeds."""

import numpy as np
from scipy import stats

from hlcs.placement import statistics
from hlcs.placement.comparison import compare_layers

SIGNIFICANCE = 0.05  # of all parameters together (Holm)


def errors_of(results, measured):
    """eps_R (Eq. 11) of every single test [-], (n,); nan where the test left no structure or a layer was not read."""
    errors = np.full(len(results), np.nan)
    for number, result in enumerate(results):
        comparison = compare_layers(result, measured)
        if result.stands and comparison.known.all():
            errors[number] = comparison.mean_relative_error
    return errors


def spread(errors):
    """Mean of the errors of single tests and its 95 % interval (Student): {"error", "error_low", "error_high"} [-]; nan where
    there are too few tests."""
    mean, low, high = statistics.mean_interval(errors)
    return {"error": mean, "error_low": low, "error_high": high}


def parameters_of(rows):
    """One dictionary a parameter of Table 1, the widest range first.

    rows: dictionaries with parameter, value, errors (of single tests) and error (their mean). Gives parameter; lowest, highest:
    of the mean errors of its values; no_structure: values no test of which left one; p: of so large differences between its
    values where only the seed makes any (F test of one-way analysis of variance), Holm's correction for all parameters in it;
    matters: whether p is below 0.05. p is nan where no value was tested twice.
    """
    found = []
    for name in dict.fromkeys(row["parameter"] for row in rows):
        own = [row for row in rows if row["parameter"] == name]
        means = [row["error"] for row in own if np.isfinite(row["error"])] or [np.nan]
        found.append(
            {
                "parameter": name,
                "lowest": min(means),
                "highest": max(means),
                "no_structure": [row["value"] for row in own if not np.isfinite(row["error"])],
                "p": _p_of([np.asarray(row["errors"]) for row in own]),
            }
        )
    known = [row for row in found if np.isfinite(row["p"])]
    for row, p in zip(known, statistics.holm([row["p"] for row in known]), strict=True):
        row["p"] = float(p)
    for row in found:
        row["matters"] = bool(row["p"] < SIGNIFICANCE)
    return sorted(found, key=lambda row: row["lowest"] - row["highest"] if np.isfinite(row["lowest"]) else np.inf)


def _p_of(groups):
    """p of the F test that groups of errors have one mean; nan where nothing tells their scatter."""
    groups = [group[np.isfinite(group)] for group in groups]
    groups = [group for group in groups if len(group)]
    freedom, values = sum(len(group) - 1 for group in groups), np.concatenate(groups or [np.zeros(0)])
    if len(groups) < 2 or not freedom:
        return np.nan
    if np.ptp(values) == 0.0:  # all alike: nothing to be told apart
        return 1.0
    return float(stats.f_oneway(*groups).pvalue)


def text_lines(rows):
    """What `hlcs reproduce table1` prints of `parameters_of`."""
    lines = ["", f"{'parameter':>18}{'eps_R % of a test':>20}{'p (Holm)':>10}  beyond the scatter between seeds?"]
    for row in rows:
        low, high = (100.0 * row[end] for end in ("lowest", "highest"))
        known = np.isfinite(row["p"])
        verdict = ("yes" if row["matters"] else "no") if known else "unknown: give --repeats 2 or more"
        out = f"; no structure at {', '.join(f'{value:g}' for value in row['no_structure'])}" if row["no_structure"] else ""
        p = f"{row['p']:.3f}" if known else "-"
        lines.append(f"{row['parameter'].replace('_', ' '):>18}{f'{low:.2f} to {high:.2f}':>20}{p:>10}  {verdict}{out}")
    return lines

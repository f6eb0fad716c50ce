"""Rows of a table that repeat each other: which do, which of them were misread, and how far the others differ."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import special

from hlcs.data.outcome_tables import OutcomeTable, off_means
from hlcs.data.quantities import OUTCOMES
from hlcs.data.rounded_readings import reading_step

LEAST_FREEDOM = 3  # from which a scatter is read
SEEN = 0.01  # probability below which chance does not explain what is seen: as of the adequacy of a model
LEAST_REPEATS = 3  # of a setting, one of which was misread: of two that differ nobody knows which is wrong
OFF = 4.0  # times the range of all others of its setting that a misread row lies off them: scatter may grow with the outcome
GROUPS_TOLD = 6  # at most, those that lie farthest off
MOST_MISREAD = 0.1  # of all rows: beyond it such rows are no misreadings but what happens
AT_ONCE = 4_000_000  # numbers that are drawn at a time: 32 MB
DRAWS = 2000  # of scatter without misreadings or order, beside which rows and settings are compared


class Repeats(NamedTuple):
    """Rows that repeat each other, and what they differ by."""

    values: np.ndarray  # less what their groups differ by, where rows of several repeat each other (n,)
    cell: np.ndarray  # equal for rows that do (n,)
    within: float  # sum of squares about the means of the cells; 0 where all rows of each agree
    freedom: int

    @classmethod
    def of(cls, values, cell, shifts=0):
        """The Repeats of values (n,) in cells, integers (n,); shifts: how many numbers were taken from the values before."""
        each, cell = np.unique(cell, return_inverse=True)
        return cls(values, cell, float(np.sum(off_means(values, cell) ** 2)), len(values) - len(each) - shifts)


class Apart(NamedTuple):
    """How rows of one setting that stand in different groups differ."""

    seen: bool  # beyond chance
    size: float  # one sigma beyond what rows of one setting and group differ by [unit of the outcome]
    inside: Repeats  # of one setting and group; of one setting, less what its groups differ by, where each stands there once


def between_groups(table):
    """The Apart of a table, by the F test of an analysis of variance within settings: of one way where groups repeat their rows,
    else of two, in which a group differs by the same at every setting."""
    group = np.unique(table.groups, return_inverse=True)[1]
    cell = np.unique(np.column_stack([table.setting, group]), axis=0, return_inverse=True)[1].reshape(-1)
    settings, inside = Repeats.of(table.values, table.setting), Repeats.of(table.values, cell)
    if inside.freedom < LEAST_FREEDOM <= min(settings.freedom, len(group) - len(np.unique(group))):
        inside, cell = _less_shifts(table, group), group
    groups = settings.freedom - inside.freedom  # degrees of freedom between the groups of a setting
    if groups <= 0 or inside.freedom < LEAST_FREEDOM or inside.within == 0:
        return Apart(False, 0.0, inside)
    of_groups, of_rows = (settings.within - inside.within) / groups, inside.within / inside.freedom
    seen = special.fdtrc(groups, inside.freedom, of_groups / of_rows) < SEEN
    return Apart(seen, float(np.sqrt(max(of_groups - of_rows, 0.0) * (inside.cell.max() + 1) / len(cell))), inside)


def _less_shifts(table, group):
    """The Repeats of settings, less the shifts of groups (n,) that leave least of them."""
    stands = (group[:, None] == np.unique(group)).astype(float)
    within = np.column_stack([off_means(column, table.setting) for column in stands.T])
    shifts, _, rank, _ = np.linalg.lstsq(within, off_means(table.values, table.setting), rcond=1e-9)
    return Repeats.of(table.values - stands @ shifts, table.setting, int(rank))


def repeats_of(table):
    """The Repeats of a table: rows of one setting, and of one group too where groups differ: another person, another clock."""
    apart = between_groups(table)
    return apart.inside if apart.seen else Repeats.of(table.values, table.setting)


def groups_told(table):
    """The note on groups that differ at equal inputs, () of none."""
    apart = between_groups(table)
    if not apart.seen:
        return ()
    clocked = table.outcome in ("fall_time_s", "slide_time_s", "bounce_time_s")
    explained = "so a clock offset is looked for in each" if clocked else "which no effect explains: compare them one by one"
    unit, off = OUTCOMES[table.outcome], off_means(table.values, table.setting)
    means = {name: float(np.mean(off[table.groups == name])) for name in np.unique(table.groups)}
    told = ", ".join(f"{name} {mean:+.2g}" for name, mean in sorted(means.items(), key=lambda each: -abs(each[1]))[:GROUPS_TOLD])
    return (
        f"rows of equal inputs differ by {apart.size:.2g} {unit} from group to group, beyond what rows of one group do: it "
        f"depends on who or what measured there, {explained}; off the means of their settings lie, in {unit}, {told}",
    )


def without_misread(table) -> tuple[OutcomeTable, tuple[str, ...]]:
    """(the table without rows that stand off all that repeat them, notes that name these).

    A row was misread or mistyped where it is farther off the median of its setting, in units of the median of all such distances,
    than the farthest of a table with normal scatter in one of a hundred, and OFF from the rest of its setting. The farthest is
    taken out, then the next is looked for.
    """
    kept, step = np.ones(len(table.values), bool), reading_step(table.values)
    while True:
        rows = np.flatnonzero(kept)
        cell, counts = np.unique(table.setting[rows], return_inverse=True, return_counts=True)[1:]
        rows, cell = rows[counts[cell] >= LEAST_REPEATS], np.unique(cell[counts[cell] >= LEAST_REPEATS], return_inverse=True)[1]
        if not len(rows) or np.sum(~kept) >= MOST_MISREAD * len(kept):
            break
        aside = off_medians(table.values[rows][:, None], cell)[:, 0]
        worst, typical = int(np.argmax(aside)), max(float(np.median(aside)), step / 2)
        others = np.sort(table.values[rows[(cell == cell[worst]) & (np.arange(len(cell)) != worst)]])
        value = table.values[rows[worst]]
        off = max(others[0] - value, value - others[-1])
        if not (typical > 0 and off > OFF * max(np.ptp(others), step) and aside[worst] > farthest(cell) * typical):
            break
        kept[rows[worst]] = False
    if kept.all():
        return table, ()
    named = ", ".join(f"{table.rows[row]} ({table.values[row]:g})" for row in np.flatnonzero(~kept))
    many = "s" if np.sum(~kept) > 1 else ""
    note = (
        f"{table.file.name}, row{many} {named}: far off all rows that repeat the same inputs, set aside for all models alike: "
        "misread or mistyped? Look them up"
    )
    columns = {name: getattr(table, name)[kept] for name in ("values", "groups", "setting", "rows")}
    inputs, errors = ({name: column[kept] for name, column in some.items()} for some in (table.inputs, table.input_sd))
    return replace(table, inputs=inputs, input_sd=errors, **columns), (note,)


def off_medians(values, cell):
    """Distance of each of values (n, draws) from the median of its cell, integers from 0 (n,)."""
    aside = np.empty_like(values)
    for here in np.split(np.argsort(cell, kind="stable"), np.cumsum(np.bincount(cell))[:-1]):
        aside[here] = np.abs(values[here] - np.median(values[here], axis=0))
    return aside


def farthest(cell):
    """How many times the median distance the farthest row of cells (n,) lies off the median of its cell, where scatter is normal;
    exceeded in one of a hundred tables."""
    generator, ratios = np.random.default_rng(12345), []
    for some in np.array_split(np.arange(DRAWS), -(-DRAWS * len(cell) // AT_ONCE)):
        aside = off_medians(generator.standard_normal((len(cell), len(some))), cell)
        ratios.append(aside.max(axis=0) / np.median(aside, axis=0))
    return float(np.quantile(np.concatenate(ratios), 1 - SEEN))

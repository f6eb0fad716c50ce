"""How strong a hidden law is, which textbook law imitates it, and with what coefficient.

Strength (discovery page): RMS that the law adds to the observations after the initial states are fitted, in sigmas.
Information: the same rows whitened for AR(1) noise and summed, i.e. the noncentrality of chi2.
"""

from copy import copy
from dataclasses import dataclass

import numpy as np

from .library import ALIASES, LIBRARY, nulls, possible, price
from .observe import COARSE, FINE, difference, film, shifted, unknowns

ALIKE, NEAR = 1.0, 27.0  # units of chi2: rivals this near are tied; beyond `NEAR` one is beaten but for 1 case in 50


def whitened(rows, rho):
    """AR(1) whitening along the samples, scaled so that white noise of one sigma stays one sigma."""
    if rho == 0:
        return rows
    out = rows.copy()
    out[1:] = (rows[1:] - rho * rows[:-1]) / np.sqrt(1 - rho**2)
    return out


@dataclass
class Lens:
    """A setup seen through a tracker: the model under test, and the space that unknown starts can absorb."""

    setup: object
    sigma_position: float
    sigma_orientation: float
    rho: float

    def __post_init__(self):
        self.base_effects = self.setup.base()
        self.base = self._look({})

    def _look(self, laws):
        """The films of the model under test with these laws beside it; what unknown starts can absorb there is kept."""
        self.plain, self.white, films = [], [], []
        for trial in self.setup.trials:
            effects = {**self.base_effects, **laws}
            plain, columns = film(self.setup, trial, effects), []
            for key, direction, step in unknowns(self.setup, trial):
                moved = film(self.setup, trial, effects, start=shifted(trial.start, key, direction, step))
                columns.append(self._rows(moved, plain) / step)
            films.append(plain)
            self.plain.append(_basis([column.ravel() for column in columns]))
            self.white.append(_basis([whitened(column, self.rho).ravel() for column in columns]))
        self._sensitivities = {}
        return films

    def beside(self, laws):
        """The same lens, what starts absorb taken where these laws act: far from the model under test it is another space."""
        there = copy(self)
        there._look(laws)
        return there

    def _rows(self, new, old):
        return difference(self.setup, new, old, self.sigma_position, self.sigma_orientation)

    def signal(self, effects, errors=None, step=COARSE):
        """Rows (one array per trial) that `effects` on top of the model under test, and wrong inputs, add; in sigmas."""
        together = {**self.base_effects, **effects}
        old = (
            self.base
            if step == COARSE
            else [film(self.setup, trial, self.base_effects, step=step) for trial in self.setup.trials]
        )
        return [
            self._rows(film(self.setup, trial, together, errors, step=step), base)
            for trial, base in zip(self.setup.trials, old, strict=True)
        ]

    def project(self, rows, white=False):
        """Rows with the part that the unknown starts absorb taken out, flat."""
        out = []
        for part, plain, bleached in zip(rows, self.plain, self.white, strict=True):
            flat = (whitened(part, self.rho) if white else part).ravel()
            basis = bleached if white else plain
            out.append(flat - basis @ (basis.T @ flat) if basis.shape[1] else flat)
        return np.concatenate(out)

    def strength(self, rows):
        """RMS of the projected rows, in sigmas."""
        return float(np.sqrt(np.mean(self.project(rows) ** 2)))

    def information(self, rows):
        """Sum of squares of the projected, whitened rows."""
        return float(np.sum(self.project(rows, white=True) ** 2))

    def sensitivities(self, name, at=None):
        """Projected, whitened derivatives (rows, p) by the parameters of library laws ({name: parameters} at `at`)."""
        if at is None and name in self._sensitivities:
            return self._sensitivities[name]
        centre = at or {name: nulls(name, self.setup)}
        base = self.project(self.signal(centre), white=True)
        columns = []
        for knob in LIBRARY[name]:
            value = centre[name][knob.name]
            step = -knob.step if value + knob.step > knob.high else knob.step
            moved = {**centre, name: {**centre[name], knob.name: value + step}}
            columns.append((self.project(self.signal(moved), white=True) - base) / step)
        result = np.stack(columns, axis=1)
        if at is None:
            self._sensitivities[name] = result
        return result

    def fit(self, names, rows, turns=4, near=None):
        """Library laws fitted to noiseless rows: ({name: parameters}, remaining information). Gauss-Newton from the null values,
        or from `near`, laws whose parameters are known to be close."""
        target = self.project(rows, white=True)
        plain = {name: nulls(name, self.setup) for name in names}
        starts = _starts(plain)
        if near:
            starts = [{name: {key: near[name].get(key, value) for key, value in plain[name].items()} for name in names}]
        return min((self._descend(names, target, start, turns) for start in starts), key=lambda found: found[1])

    def _descend(self, names, target, laws, turns):
        """Gauss-Newton with halved steps from one start: ({name: parameters}, remaining information)."""
        residual = target - self.project(self.signal(laws), white=True)
        left = float(residual @ residual)
        for _ in range(turns):
            design = np.concatenate([self.sensitivities(name, laws) for name in names], axis=1)
            change = np.linalg.lstsq(design, residual, rcond=1e-10)[0]
            for shrink in (1.0, 0.4, 0.1):
                tried = _moved(laws, names, shrink * change)
                rest = target - self.project(self.signal(tried), white=True)
                if np.isfinite(rest).all() and rest @ rest < left:
                    gain, laws, residual, left = left - rest @ rest, tried, rest, float(rest @ rest)
                    break
            else:
                break
            if gain < 1e-3 * (1 + left):
                break
        return laws, left

    def cosine(self, name, rows):
        """Cosine between noiseless rows and what a library law can do near its null value."""
        target = self.project(rows, white=True)
        design = self.sensitivities(name)
        basis = _basis(list(design.T))
        return float(np.linalg.norm(basis.T @ target) / max(np.linalg.norm(target), 1e-300))

    def count(self):
        """Number of observed numbers."""
        return sum(part.size for part in self.signal({}))


def _basis(columns):
    """Orthonormal basis of the span of the columns; columns that are nothing or repeats are left out."""
    if not columns:
        return np.zeros((1, 0))
    matrix = np.stack(columns, axis=1)
    size = np.linalg.norm(matrix, axis=0)
    matrix = matrix / np.where(size > 1e-12, size, 1.0)
    left, values, _ = np.linalg.svd(matrix, full_matrices=False)
    return left[:, values > 1e-7]


def _starts(laws):
    """Where the search begins: null values, or beside them where the null value hides the law's other parameters."""
    if "stribeck_friction" in laws:
        return [{**laws, "stribeck_friction": {"ratio": 1.1, "speed": speed}} for speed in (0.12, 0.3)]
    if "anisotropic_friction" in laws:
        return [{**laws, "anisotropic_friction": {"ratio": 1.02, "angle": angle}} for angle in (0.4, 1.2)]
    if "drag_crisis" in laws:
        beyond = [{"subcritical": 0.5, "supercritical": 0.15, "critical_reynolds": place} for place in (0.8e5, 1.6e5)]
        return [{**laws, "drag_crisis": law} for law in beyond]
    if laws.get("restitution", {}).get("coefficient") == 0:  # a rebound goes with the square
        return [{**laws, "restitution": {"coefficient": 0.1}}]
    return [laws]


def _moved(laws, names, change):
    """Laws with their parameters moved, kept within a few times their ranges so that a wild step cannot break the simulation."""
    moved, k = {}, 0
    for name in names:
        moved[name] = dict(laws[name])
        for knob in LIBRARY[name]:
            reach = knob.high - knob.low
            low = knob.low - 2 * reach if knob.low < 0 or name in ("length_scale", "time_scale") else knob.low
            low = {"subcritical": 0.0, "critical_reynolds": 1e4}.get(knob.name, low)
            if name in ("buoyancy", "linear_drag", "quadratic_drag", "added_mass", "rolling_friction"):
                low = -knob.high  # lets an impossible sign show itself; `inside` then refuses it
                low = max(low, -0.5) if name == "added_mass" else low
            moved[name][knob.name] = float(np.clip(laws[name][knob.name] + change[k], low, knob.high + 2 * reach))
            k += 1
    return moved


def scaled(lens, make, target, first):
    """Amplitude a (and its rows) at which make(a) = {effect: parameters} has the target strength on top of the model."""
    amplitude = first
    for _ in range(12):
        rows = lens.signal(make(amplitude))
        strength = lens.strength(rows)
        if not np.isfinite(strength) or strength < 1e-9:
            return None
        if abs(strength / target - 1) < 0.01:
            return amplitude
        amplitude *= float(np.clip(target / strength, 0.02, 50))
    return amplitude if abs(strength / target - 1) < 0.1 else None


def gentle(lens, names, limits, room=0.5):
    """Wrong nominal inputs {name: deviation}, each shrunk until it is far below the noise: information <= room."""
    errors = {}
    for name, value in zip(names, limits, strict=True):
        information = lens.information(lens.signal({}, errors={name: value}))
        errors[name] = float(value * min(1.0, np.sqrt(room / max(information, 1e-12))))
    return errors


def look_alikes(lens, hidden, rows, truth_left):
    """Rivals of a single hidden law, by what their laws can do and not by what is plausible: (tied; possibly reported beside it;
    largest cosine of a rival; units of chi2 by which the nearest is beaten; name of a law with fewer parameters that imitates
    it wholly, or None). A law that contains the hidden one is beaten by the price of its further numbers."""
    unit = np.log(lens.count())
    tied, beside, largest, nearest, simpler = [], list(ALIASES.get(hidden, ())), 0.0, np.inf, None
    for name in lens.setup.rivals:
        if name == hidden:
            continue
        cosine = lens.cosine(name, rows)
        if cosine < 0.5:
            continue
        law, left = lens.fit([name], rows)
        behind = left - truth_left + unit * (price(name) - price(hidden))
        if possible(name, law[name]) and name not in lens.base_effects:  # a law of the model refitted: allowed, not asked for
            largest, nearest = max(largest, cosine), min(nearest, behind)
            if abs(left - truth_left) < ALIKE and abs(behind) < ALIKE:
                tied.append(name)
            elif cosine > 0.99 and behind < -ALIKE:
                simpler = name
        if behind < NEAR or cosine > 0.99:
            beside.append(name)
    return tied, sorted(set(beside)), largest, float(nearest), simpler


__all__ = ["FINE", "NEAR", "Lens", "gentle", "look_alikes", "scaled", "whitened"]

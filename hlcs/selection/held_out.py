"""What an effect is worth on recordings that its numbers were not fitted to."""

from dataclasses import dataclass

import numpy as np
from scipy import special

from hlcs.selection.reasons import Rule
from hlcs.selection.thresholds import BEATEN, BY_CHANCE, FALL, FALL_IN_SIGMA, TIED


@dataclass(frozen=True)
class HeldOut:
    """One effect more or less, on held-out recordings."""

    p: float = 1.0  # one-sided, of being no better with it
    directions: tuple[float, ...] = ()  # relative fall of the error in each direction
    falls: float = 0.0  # relative fall of the error, all directions
    falls_in_sigma: float = 0.0

    def broken(self, few, count):
        """Explanation of the rule that it breaks, chosen among `count` candidates, None of none; few: so few recordings that each
        half must show a fall, of FALL, or of any size where both together leave nothing to chance."""
        if not self.directions:
            return None  # nothing could be held out
        p = min(1.0, count * self.p)  # Bonferroni's bound: Holm's first step
        if few:
            together = min(self.directions) > 0 and p < BY_CHANCE and self.falls > FALL
            changes = " and ".join(f"{-100 * fall:+.0f} %" for fall in self.directions)
            return None if together or min(self.directions) > FALL else Rule.BOTH_DIRECTIONS(changes=changes)
        if p >= BY_CHANCE:
            return Rule.NO_CHANCE(p=p)
        if self.falls <= FALL and self.falls_in_sigma <= FALL_IN_SIGMA:
            return Rule.HELD_OUT_ERROR(percent=100 * self.falls)
        return None


def held_out(problem, cross_validation, before, after):
    """The HeldOut of what a fit `after` has more than a fit `before`."""
    if not cross_validation.possible:
        return HeldOut()
    r0, r1 = cross_validation.residuals(before), cross_validation.residuals(after)
    dots = spread = clustered = 0.0
    for a, b in zip(r0, r1, strict=True):
        difference = a - b
        dots += float(difference @ a)
        spread += float(difference @ difference)
        clustered += float(difference @ b) ** 2
    p = float(special.ndtr(-dots / np.sqrt(max(spread, clustered)))) if spread > 0 else 1.0
    raw0, raw1 = problem.in_sigmas(r0), problem.in_sigmas(r1)
    directions = tuple(fall(rms([raw0[k] for k in half]), rms([raw1[k] for k in half])) for half in cross_validation.halves)
    e0, e1 = rms(raw0), rms(raw1)
    return HeldOut(p, directions, fall(e0, e1), e0 - e1)


def fall(before, after):
    """Relative fall of an error; of an error of zero nothing can fall, and what rises from there is all of it."""
    return 1 - after / before if before else -float(after > 0)


def beaten(cross_validation, fit, other):
    """Does `other` predict recordings that it was not fitted to worse than `fit`: at p < 0.01, and by more than TIED?

    The difference of -2 log of what each half foretells of the other is set beside its own spread, so that neither law need be
    the true one (Q. H. Vuong, Econometrica 57 (1989) 307). What a half tells badly of the numbers of a law widens what it
    foretells: that they are badly known is no evidence against it. As odds, less than TIED tells no law from another.
    """
    if not cross_validation.possible:
        return False
    (a, more), (b, less) = (cross_validation.foretold(each) for each in (other, fit))
    worse, spread = float(a @ a - b @ b) + more - less, 2 * np.linalg.norm(a - b)
    return bool(worse > max(TIED, -special.ndtri(BEATEN) * spread))


def rms(parts):
    """Root mean square of all numbers of a list of arrays."""
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def fitted_error(problem, fit):
    """RMS residual of a fit on the data it was fitted to."""
    return problem.error(fit.linearization.projected[0])


def held_out_error(problem, cross_validation, fit):
    """RMS residual on recordings the numbers were not fitted to; None where nothing can be held out."""
    return problem.error(cross_validation.residuals(fit)) if cross_validation.possible else None

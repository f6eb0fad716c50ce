"""`hlcs effects`: every effect by name, a wrong name with the one that was meant, the user's own among them."""

import json

from hlcs.effects import classes
from hlcs.kinds.layers.candidates import WORDS

OWN = '''
from dataclasses import dataclass
import minibullet as mb

@dataclass(frozen=True)
class SideWind(mb.Effect):
    """A push along x in proportion to the mass."""
    push: float = mb.parameter(0.0, unit="m/s2", low=-5.0, high=5.0, null=0.0)
    isotropic = False
    def forces(self, bodies, time):
        wrench = 0.0 * bodies.twist
        wrench[:, 0] = self.push * bodies.mass
        return wrench
'''


def test_all_effects_of_a_diagnosis_are_listed(hlcs):
    """Those with a class, and those that only tests of layers know."""
    status, out, _ = hlcs("effects", "--json", "-")
    names = {entry["name"] for entry in json.loads(out)["effects"]}
    assert status == 0 and names == {*classes(), *WORDS}


def test_one_effect_is_told_with_law_numbers_and_look_alikes(hlcs):
    status, out, _ = hlcs("effects", "quadratic_drag")
    assert status == 0
    for words in ("F = -(rho C A/2 + k m) |w| w", "smooth sphere; Hoerner (1965)", "linear_drag", "mb.QuadraticDrag("):
        assert words in out


def test_a_wrong_name_is_refused_with_the_one_that_was_meant(hlcs):
    status, out, error = hlcs("effects", "quadratic_drg")
    assert (status, out) == (2, "") and "did you mean 'quadratic_drag'?" in error and error.count("\n") == 1


def test_effects_of_your_own_are_listed(hlcs, tmp_path):
    (tmp_path / "own.py").write_text(OWN)
    status, out, _ = hlcs("effects", "side_wind", "--effects", "own.py")
    assert status == 0 and "A push along x in proportion to the mass." in out and "-5 to 5" in out

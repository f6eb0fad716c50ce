"""Shortcuts of the model itself: what disappears when they are taken back."""

from dataclasses import dataclass, replace

from hlcs.data.rigid_body import rigid_body
from hlcs.effects.contract import Change
from minibullet.effects.contract import Need, parameter


@dataclass(frozen=True)
class MarginOffset(Change):
    """Contacts keep a gap open."""

    offset: float = parameter(
        0.0,
        unit="Dn",
        low=0.0,
        high=0.02,
        null=0.0,
        source="Molines et al. (2021): 0.008 Dn",
        about="gap over the side of the cube of equal volume, Dn",
        typical=((0.008, "collision margin of the tests in Blender"),),
    )
    plain = "a gap that contacts keep open"
    formula = "gap = offset L"
    looks_like = "All that rests stands a little too high, each layer of a stack by the same; flights show nothing."
    confused_with = ("bottom_slope",)
    group = "contact_normal"
    alike = "rest_height"
    needs = (Need.CONTACT,)

    def setup(self, setup):
        return replace(setup, margin=setup.margin + self.offset * rigid_body(setup.body).volume ** (1 / 3))

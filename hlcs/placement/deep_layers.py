"""Fixed layers deep under the one that is placed, out of the way of the engine: a unit of a large structure costs as much time as
one of a small structure.

A step costs time for every body in the world, also for those that never move again. What lies three layers deep is touched by
nothing but units that roll down a flank. So it is set aside, and what a moving unit comes near to is brought back before it can
be touched.
"""

import numpy as np
from scipy import spatial

KEPT = 2  # layers under the one to be placed that stay whole: a unit that falls into a hollow reaches the second [-]
AT_HAND = 1000  # units below which nothing is set aside: there a step spends its time on contacts, not on fixed bodies [-]
NEAR = (
    2.5  # bounding radii between centres at which a unit is brought back: two spheres touch at 2; a step moves far less than 0.5
)


class DeepLayers:
    """The units of a World that are set aside, and the watch over them."""

    def __init__(self, world, at_hand=AT_HAND):
        self.world, self.at_hand, self.aside, self._tree = world, at_hand, [], None

    def set_aside(self, layers):
        """Set aside what lies deeper than the last KEPT of the layers (tuples of fixed handles), where there are many units."""
        if sum(map(len, layers)) <= self.at_hand:
            return
        known = set(self.aside)
        deep = [handle for layer in layers[:-KEPT] for handle in layer if handle not in known]
        if deep:
            self.world.set_aside(deep)
            self._hold([*self.aside, *deep])

    def at_hand_of(self, layers):
        """The layers without what is set aside: (tuple of handles, ...)."""
        known = set(self.aside)
        return [tuple(handle for handle in layer if handle not in known) for layer in layers]

    def watch(self, layer, world):
        """Bring back what a moving unit has come near to; to be called after every step, whatever layer settles."""
        if not self.aside:
            return
        bodies = world.last_step.after
        moving = bodies.position[np.isfinite(bodies.mass)]
        low = moving[moving[:, 2] < self._top + self._reach]
        if not len(low):
            return
        near = sorted({int(k) for found in self._tree.query_ball_point(low, self._reach) for k in found})
        if near:
            world.bring_back([self.aside[k] for k in near])
            chosen = set(near)
            self._hold([handle for k, handle in enumerate(self.aside) if k not in chosen])

    def _hold(self, handles):
        """Remember these units, and where they are."""
        self.aside = handles
        places = np.reshape([handle.position for handle in handles], (-1, 3))
        self._tree = spatial.cKDTree(places) if handles else None
        self._top = places[:, 2].max(initial=-np.inf)
        self._reach = NEAR * max((handle.shape.bounding_radius for handle in handles), default=0.0)

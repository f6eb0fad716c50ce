"""What a placement test gave: layers, their scatter, what was lost; how it is shown and saved is told by its renderer."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hlcs.files.versions import versions
from hlcs.placement import layer_equations
from hlcs.placement.grids import interior_density
from hlcs.placement.layer_placement import in_place, level_of
from hlcs.placement.sea_bottom import height_above
from hlcs.placement.settings_table import placement_table
from hlcs.rendering import Result, renderer_of

MISPLACED = 0.5  # a unit that comes to rest farther than this from its aim, in plan, is misplaced [Dn]


@dataclass(frozen=True, eq=False, repr=False)
class PlacementResult(Result):
    """What a placement test gave: a frozen value.

    test: the PlacementTest; readings: per layer the plates' heights above the bottom [m], NaN where the layer alone does not
    carry the plate at rest; poses: per layer (n, 7) positions [m] and orientations; records: how each layer came to rest;
    wall_seconds; carried_by: per layer and plate, in words, what carries it; aims: per layer (n, 2) where its units were aimed
    in plan [m]; notices: what the engine had to tell, one line each; plates: per layer (k, 3) where the middle of each plate's
    lower face came to rest [m]; standing: per layer, which units stand in it, at rest and carried (n,) (the last five empty in
    results of earlier versions).

    A layer on which no plate finds support has no height: it is NaN, and so is all that is reckoned from it.
    """

    test: object
    readings: tuple
    poses: tuple
    records: tuple
    wall_seconds: float = 0.0
    carried_by: tuple = ()
    aims: tuple = ()
    notices: tuple = ()
    plates: tuple = ()
    standing: tuple = ()

    @cached_property
    def heights(self):
        """Mean height of the envelope after each layer [Dn], (M,); NaN where no plate found support."""
        return np.array([np.nanmean(r) if np.isfinite(r).any() else np.nan for r in self.readings]) / self._dn

    @cached_property
    def layer_coefficients(self):
        """k_j = (h_j - h_(j-1)) / Dn, Eq. (3), (M,); NaN where either height is."""
        return layer_equations.layer_coefficients(self.heights)

    @cached_property
    def cv(self):
        """Scatter of single plates: standard deviation of the readings of a layer over k_j Dn, (M,)."""
        spread = [np.nanstd(r, ddof=1) if np.isfinite(r).sum() > 1 else np.nan for r in self.readings]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.array(spread) / self._dn / self.layer_coefficients

    @cached_property
    def fallen_layers(self):
        """Numbers of the layers that are none: they carry no plate, and of
        their units fewer than half stand in them, at rest and carried."""
        units = np.array([len(poses) for poses in self.poses])
        stand = units - self.lost - [record.unsettled for record in self.records]
        return (np.flatnonzero(np.isnan(self.heights) & (2 * stand < np.maximum(units, 1))) + 1).tolist()

    @property
    def stands(self):
        """Whether the run left a structure: no layer is fallen. One that stands may be too small or too smooth for a plate."""
        return not self.fallen_layers

    @property
    def height_over_dn(self):
        """Total height [Dn], Eq. (14); NaN where no plate found support on the last layer."""
        return float(self.heights[-1])

    @cached_property
    def plate_levels(self):
        """Levels of the plates above the datum z = 0, per layer (k,) [m]; NaN where the reading was left out."""
        pairs = zip(self.plates, self.readings, strict=False)
        return tuple(np.where(np.isfinite(heights), faces[:, 2], np.nan) for faces, heights in pairs)

    @cached_property
    def levels(self):
        """Mean level of the plates on each layer above the datum [m], (M,); NaN where none found support."""
        known = [levels[np.isfinite(levels)] for levels in self.plate_levels]
        return np.array([levels.mean() if len(levels) else np.nan for levels in known] or [np.nan] * len(self.poses))

    @property
    def crest_level(self):
        """Level of the structure's top above the datum z = 0: mean of the plates on the last layer [m]; NaN where none is."""
        return float(self.levels[-1])

    @property
    def crest_level_sd(self):
        """Standard deviation of single plates about `crest_level` [m]; NaN with fewer than two plates."""
        levels = self.plate_levels[-1][np.isfinite(self.plate_levels[-1])] if self.plate_levels else ()
        return float(np.std(levels, ddof=1)) if len(levels) > 1 else np.nan

    @property
    def concrete(self):
        """Volume of all units that were placed [m3]."""
        return sum(len(poses) for poses in self.poses) * self.test.unit.volume

    @property
    def units_per_metre(self):
        """Units of one cross-section (across the rows, along y) per metre of length (along the rows, x) [1/m], as planned: what a
        long structure of this section takes, without the ends of the test section."""
        rows = sum(self.test.rows - below for below in range(len(self.poses)))
        return rows / (self.test.grid.spacing_x * self._dn)

    @cached_property
    def in_layer(self):
        """Per layer, which units are in it (n,): those that did not fall to the level of the layer under it or deeper."""
        level, found = -np.inf, []
        for poses in self.poses:
            heights = height_above(self.test.bottom, poses[:, :3])
            found.append(in_place(heights, level, self._dn))
            level = level_of(heights, level, self._dn)
        return tuple(found)

    @cached_property
    def lost(self):
        """Units of each layer that fell out of it: centre less than half a Dn above the median centre of the layer under it, or
        below it, (M,)."""
        return np.array([int((~inside).sum()) for inside in self.in_layer])

    @cached_property
    def misses(self):
        """How far every unit came to rest from its aim, in plan: per layer (n, 2) [Dn]."""
        return tuple((poses[:, :2] - aims) / self._dn for poses, aims in zip(self.poses, self.aims, strict=False))

    @cached_property
    def misplaced(self):
        """Whether every unit came to rest farther than MISPLACED from its aim, in plan: per layer booleans (n,)."""
        return tuple(np.linalg.norm(miss, axis=1) > MISPLACED for miss in self.misses)

    @cached_property
    def drift(self):
        """How far the middle of each layer came to rest from where it was aimed, in plan: length of the mean of `misses` over
        the units that are in the layer [Dn], (M,); NaN where none is."""
        known = zip(self.misses, self.in_layer, strict=False)
        found = [np.linalg.norm(miss[inside].mean(axis=0)) if inside.any() else np.nan for miss, inside in known]
        return np.array(found or [np.nan] * len(self.poses))

    @property
    def porosity(self):
        """Nominal porosity, 1 - M phi / height, with the packing density phi of the grid [-] (Eq. 2)."""
        return self._porosity(self.test.grid.packing_density)

    @cached_property
    def achieved_packing_density(self):
        """Units per Dn^2 in plan where the units came to rest, inner part of every layer, mean of the layers [-]; NaN where no
        layer has an inner part."""
        pairs = zip(self.poses, self.in_layer, strict=True)
        found = np.array([interior_density(poses[inside, :2] / self._dn) for poses, inside in pairs])
        return float(np.nanmean(found)) if np.isfinite(found).any() else np.nan

    @property
    def achieved_porosity(self):
        """1 - M phi / height, with the achieved packing density phi [-]."""
        return self._porosity(self.achieved_packing_density)

    def _porosity(self, packing_density):
        """1 - M phi / height of M layers [-]."""
        return layer_equations.nominal_porosity(len(self.poses), self.height_over_dn, packing_density)

    @property
    def _dn(self):
        return self.test.unit.nominal_diameter

    def layer_rows(self):
        """One dictionary a layer, as `to_dataframe` has them; None where a layer has no such value."""
        dn = self._dn
        return [
            {
                "layer": j + 1,
                "k": _known(k),
                "readings": int(np.isfinite(self.readings[j]).sum()),
                "cv": _known(self.cv[j]),
                "units": len(self.poses[j]),
                "lost": int(self.lost[j]),
                "unsettled": self.records[j].unsettled,
                "unsupported_readings": int(np.isnan(self.readings[j]).sum()),
                "lifted_units": self.records[j].lifted,
                "mean_lift_over_dn": self.records[j].mean_lift / dn,
                "redrawn_units": self.records[j].redrawn,
                "drift_over_dn": _known(self.drift[j]),
                "level_m": _known(self.levels[j]),
            }
            | self._repair(j)
            for j, k in enumerate(self.layer_coefficients)
        ]

    def _repair(self, j):
        """Of a repair, what was added to the layer; nothing of other tests."""
        if not self.test.standing:
            return {}
        return {"added_units": self.records[j].added, "covered_places": self.records[j].covered}

    def to_dict(self):
        """The JSON of ``hlcs place``; None where there is no such value."""
        test, dn = self.test, self._dn
        return {
            "format": 1,
            "grid": test.grid.name,
            "spacing_x": test.grid.spacing_x,
            "spacing_y": test.grid.spacing_y,
            "seed": test.seed,
            "shape": test.shape,
            "nominal_diameter_m": dn,
            "unit": test.unit.facts(test.density),
            "layers": self.layer_rows(),
            "height_over_dn": _known(self.height_over_dn),
            "porosity": _known(self.porosity),
            "packing_density": test.grid.packing_density,
            "achieved_porosity": _known(self.achieved_porosity),
            "achieved_packing_density": _known(self.achieved_packing_density),
            "crest_level_m": _known(self.crest_level),
            "crest_level_sd_m": _known(self.crest_level_sd),
            "concrete_m3": self.concrete,
            "units_per_m": self.units_per_metre,
            "concrete_m3_per_m": self.units_per_metre * test.unit.volume,
            "structure": self.stands,
            "pushed_over_dn": self.records[0].pushed / dn,
            "max_penetration_over_dn": max(r.penetration for r in self.records) / dn,
            "max_transient_penetration_over_dn": max(r.transient_penetration for r in self.records) / dn,
            "wall_seconds": self.wall_seconds,
            "unsolved_steps": sum(r.unsolved_steps for r in self.records),
            "steps": sum(r.steps for r in self.records),
            "plates": [
                {"layer": j, "height_over_dn": [_known(h) for h in heights / dn], "carried_by": list(words)}
                for j, (heights, words) in enumerate(zip(self.readings, self.carried_by, strict=False), start=1)
            ],
            "notices": list(self.notices),
            "settings": placement_table(test),
            "versions": versions(),
        }

    def to_dataframe(self):
        """One row a layer: layer, k, readings, cv, units, lost, unsettled, unsupported_readings, lifted_units,
        mean_lift_over_dn, redrawn_units, drift_over_dn, level_m; NaN where a layer has no such value."""
        import pandas as pd

        return pd.DataFrame(self.layer_rows())

    @classmethod
    def load(cls, folder):
        """The result that `save` wrote."""
        return renderer_of(cls).load(folder)


def _known(value):
    """A float, None where it is not finite: what JSON has for it."""
    return float(value) if np.isfinite(value) else None

"""What a placement test gave: layers, their scatter, what was lost; as text, table, JSON, files."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hlcs.placement.grids import interior_density
from hlcs.placement.layer_placement import in_place, level_of
from hlcs.placement.sea_bottom import height_above


@dataclass(frozen=True, eq=False)
class PlacementResult:
    """What a placement test gave: a frozen value.

    test: the PlacementTest; readings: per layer the plates' heights above the bottom [m], NaN where the layer alone does not
    carry the plate at rest; poses: per layer (n, 7) positions [m] and orientations; records: how each layer came to rest;
    wall_seconds; carried_by: per layer and plate, in words, what carries it; aims: per layer (n, 2) where its units were aimed
    in plan [m]; notices: what the engine had to tell, one line each (the last three empty in results of earlier versions).

    A layer on which no plate finds support has no height: it is NaN, and so is all that is reckoned from it.
    """

    test: object
    readings: tuple = field(repr=False)
    poses: tuple = field(repr=False)
    records: tuple = field(repr=False)
    wall_seconds: float = 0.0
    carried_by: tuple = field(default=(), repr=False)
    aims: tuple = field(default=(), repr=False)
    notices: tuple = field(default=(), repr=False)

    @cached_property
    def heights(self):
        """Mean height of the envelope after each layer [Dn], (M,); NaN where no plate found support."""
        return np.array([np.nanmean(r) if np.isfinite(r).any() else np.nan for r in self.readings]) / self._dn

    @cached_property
    def layer_coefficients(self):
        """k_j = (h_j - h_(j-1)) / Dn, Eq. (3), (M,); NaN where either height is."""
        return np.diff(self.heights, prepend=0.0)

    @cached_property
    def cv(self):
        """Scatter of single plates: standard deviation of the readings of a layer over k_j Dn, (M,)."""
        spread = [np.nanstd(r, ddof=1) if np.isfinite(r).sum() > 1 else np.nan for r in self.readings]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.array(spread) / self._dn / self.layer_coefficients

    @cached_property
    def fallen_layers(self):
        """Numbers of the layers that are none: they carry no plate, and of their units fewer than half stand in them, at rest and
        carried."""
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
        height = self.height_over_dn
        return float(1.0 - len(self.poses) * packing_density / height) if height > 0.0 else np.nan

    @property
    def _dn(self):
        return self.test.unit.nominal_diameter

    def to_dict(self):
        """The JSON of ``hlcs place``; None where there is no such value."""
        from hlcs.files import folders
        from hlcs.placement.placement_file import placement_table

        test, dn = self.test, self._dn
        layers = [
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
                "drift_over_dn": _known(self.drift[j]),
            }
            for j, k in enumerate(self.layer_coefficients)
        ]
        return {
            "format": 1,
            "grid": test.grid.name,
            "spacing_x": test.grid.spacing_x,
            "spacing_y": test.grid.spacing_y,
            "seed": test.seed,
            "shape": test.shape,
            "nominal_diameter_m": dn,
            "layers": layers,
            "height_over_dn": _known(self.height_over_dn),
            "porosity": _known(self.porosity),
            "packing_density": test.grid.packing_density,
            "achieved_porosity": _known(self.achieved_porosity),
            "achieved_packing_density": _known(self.achieved_packing_density),
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
            "versions": folders.versions(),
        }

    def to_dataframe(self):
        """One row a layer: layer, k, readings, cv, units, lost, unsettled, unsupported_readings, lifted_units,
        mean_lift_over_dn, drift_over_dn; NaN where a layer has no such value."""
        import pandas as pd

        return pd.DataFrame(self.to_dict()["layers"])

    def save(self, folder):
        """Write layers.csv, result.json, poses.npz, settings.toml, scene.glb, structure.png and report.html into a folder;
        returns it."""
        from hlcs.placement.result_files import save_placement

        return save_placement(self, folder)

    @staticmethod
    def load(folder):
        """The result that `save` wrote."""
        from hlcs.placement.result_files import load_placement

        return load_placement(folder)

    def summary(self):
        """A few lines of text: the layers, the height, what was lost or did not settle."""
        data = self.to_dict()
        lines = [
            f"{data['grid']} grid, {len(self.poses)} layers, {sum(len(p) for p in self.poses)} units, shape {data['shape']}, "
            f"contact friction {self.test.friction:g}, seed {data['seed']}",
            "layer       k   plates  left out      CV  units  lost  unsettled",
        ]
        lines += [
            f"{r['layer']:5d}  {or_dash(r['k'], '.3f'):>6}  {r['readings']:6d}  {r['unsupported_readings']:8d}  "
            f"{or_dash(r['cv'], '.4f'):>6}  {r['units']:5d}  {r['lost']:4d}  {r['unsettled']:9d}"
            for r in data["layers"]
        ]
        lines += [
            f"height {or_dash(data['height_over_dn'], '.3f')} Dn, deepest overlap {data['max_penetration_over_dn']:.1e} Dn, "
            f"{self.wall_seconds:.1f} s",
            f"porosity {or_dash(data['achieved_porosity'], '.3f')} achieved, {or_dash(data['porosity'], '.3f')} nominal; packing "
            f"density {or_dash(data['achieved_packing_density'], '.3f')} achieved, {data['packing_density']:.3f} nominal",
            *self.notes(),
        ]
        return "\n".join(lines)

    def notes(self):
        """What a reader must know beside the table: one sentence each."""
        found, dn = [], self._dn
        if self.fallen_layers:
            layers = ", ".join(map(str, self.fallen_layers))
            found.append(f"no structure: layer {layers} carries no plate, and most of its units fell, move or hang in the air")
        absent, known = np.flatnonzero(np.isnan(self.heights)) + 1, np.flatnonzero(np.isfinite(self.heights)) + 1
        if len(absent):
            last = f"layer {known[-1]} is {self.heights[known[-1] - 1]:.3f} Dn high" if len(known) else "no layer was read"
            found.append(f"no height of layer {', '.join(map(str, absent))}: no plate lies on it alone; {last}")
        if (pushed := self.records[0].pushed / dn) >= 5e-4:  # shown as 0.001
            found.append(f"first layer pushed apart by up to {pushed:.3f} Dn: its units overlapped as they were laid")
        for j, words in enumerate(self.carried_by, start=1):
            out = np.isnan(self.readings[j - 1])
            if out.any():
                kinds = [word for word, left in zip(words, out, strict=True) if left]
                counted = ", ".join(f"{kinds.count(kind)} on {kind}" for kind in dict.fromkeys(kinds))
                found.append(f"plates left out of layer {j}: {counted}")
        if unsolved := sum(record.unsolved_steps for record in self.records):
            steps = sum(record.steps for record in self.records)
            found.append(f"{unsolved} of {steps} steps did not reach residual {self.test.tolerance:g}")
        return [*found, *self.notices]

    __str__ = summary

    def _repr_html_(self):
        return f"<pre>{self.summary().splitlines()[0]}</pre>" + self.to_dataframe().to_html(index=False)


def _known(value):
    """A float, None where it is not finite: what JSON has for it."""
    return float(value) if np.isfinite(value) else None


def or_dash(value, form):
    """A number in a form, "-" where there is none."""
    return format(value, form) if value is not None and np.isfinite(value) else "-"

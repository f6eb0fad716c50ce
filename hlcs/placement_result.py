"""What a placement test gave: layers, their scatter, what was lost; as text, table, JSON, files."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hlcs import statistics


@dataclass(frozen=True, eq=False)
class PlacementResult:
    """What a placement test gave: a frozen value.

    test: the PlacementTest; readings: per layer the plates' heights above the bottom [m], NaN where a plate found no rest;
    poses: per layer (n, 7) positions [m] and orientations; records: how each layer came to rest; wall_seconds.
    """

    test: object
    readings: tuple = field(repr=False)
    poses: tuple = field(repr=False)
    records: tuple = field(repr=False)
    wall_seconds: float = 0.0

    @cached_property
    def heights(self):
        """Mean height of the envelope after each layer [Dn], (M,)."""
        return np.array([np.nanmean(r) for r in self.readings]) / self.test.unit.nominal_diameter

    @cached_property
    def layer_coefficients(self):
        """k_j = (h_j - h_(j-1)) / Dn, Eq. (3), (M,)."""
        return np.diff(self.heights, prepend=0.0)

    @cached_property
    def cv(self):
        """Scatter of single plates: standard deviation of the readings of a layer over k_j Dn, (M,)."""
        dn = self.test.unit.nominal_diameter
        return (
            np.array([np.nanstd(r, ddof=1) / dn if np.isfinite(r).sum() > 1 else np.nan for r in self.readings])
            / self.layer_coefficients
        )

    @property
    def height_over_dn(self):
        """Total height [Dn], Eq. (14)."""
        return float(self.heights[-1])

    @cached_property
    def lost(self):
        """Units of each layer that fell out of it: centre below the median centre of the layer under it, (M,)."""
        heights = [p[:, 2] - self.test.bottom.height(*p[:, :2].T) for p in self.poses]
        return np.array([0] + [int((heights[j] < np.median(heights[j - 1])).sum()) for j in range(1, len(heights))])

    @property
    def porosity(self):
        """1 - n phi / sum k [-], from Eq. (2)."""
        return float(statistics.porosity(self.test.grid.packing_density, self.layer_coefficients))

    def to_dict(self):
        """The JSON of ``hlcs place``."""
        from hlcs import files
        from hlcs.placement_files import placement_table

        test, dn = self.test, self.test.unit.nominal_diameter
        layers = [
            {
                "layer": j + 1,
                "k": float(k),
                "readings": int(np.isfinite(self.readings[j]).sum()),
                "cv": float(self.cv[j]),
                "units": len(self.poses[j]),
                "lost": int(self.lost[j]),
                "unsettled": self.records[j].unsettled,
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
            "height_over_dn": self.height_over_dn,
            "porosity": self.porosity,
            "packing_density": test.grid.packing_density,
            "max_penetration_over_dn": max(r.penetration for r in self.records) / dn,
            "max_transient_penetration_over_dn": max(r.transient_penetration for r in self.records) / dn,
            "wall_seconds": self.wall_seconds,
            "unsolved_steps": sum(r.unsolved_steps for r in self.records),
            "steps": sum(r.steps for r in self.records),
            "settings": placement_table(test),
            "versions": files.versions(),
        }

    def to_dataframe(self):
        """One row a layer: layer, k, readings, cv, units, lost, unsettled."""
        import pandas as pd

        return pd.DataFrame(self.to_dict()["layers"])

    def save(self, folder):
        """Write layers.csv, result.json, poses.npz, settings.toml, scene.glb, structure.png and report.html into a folder;
        returns it."""
        from hlcs.results import save_placement

        return save_placement(self, folder)

    @staticmethod
    def load(folder):
        """The result that `save` wrote."""
        from hlcs.results import load_placement

        return load_placement(folder)

    def summary(self):
        """A few lines of text: the layers, the height, what was lost or did not settle."""
        data = self.to_dict()
        lines = [
            f"{data['grid']} grid, {len(self.poses)} layers, {sum(len(p) for p in self.poses)} units, shape {data['shape']}, "
            f"contact friction {self.test.friction:g}, seed {data['seed']}",
            "layer       k   plates      CV  units  lost  unsettled",
        ]
        lines += [
            f"{r['layer']:5d}  {r['k']:6.3f}  {r['readings']:6d}  {r['cv']:6.4f}  {r['units']:5d}  {r['lost']:4d}  "
            f"{r['unsettled']:9d}"
            for r in data["layers"]
        ]
        lines.append(
            f"height {data['height_over_dn']:.3f} Dn, porosity {data['porosity']:.3f}, "
            f"packing density {data['packing_density']:.3f}, deepest overlap {data['max_penetration_over_dn']:.1e} Dn, "
            f"{self.wall_seconds:.1f} s"
        )
        if data["unsolved_steps"]:
            lines.append(f"{data['unsolved_steps']} of {data['steps']} steps did not reach residual {self.test.tolerance:g}")
        return "\n".join(lines)

    __str__ = summary

    def _repr_html_(self):
        return f"<pre>{self.summary().splitlines()[0]}</pre>" + self.to_dataframe().to_html(index=False)

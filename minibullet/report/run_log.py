"""The books of a whole run: what every step published, and what is to be said at its end."""

import csv
import io

from minibullet.values import table

COLUMNS = (
    "step", "t", "dt", "n_contacts", "n_active", "residual", "residual_rho1", "cone", "dual", "signorini", "slip",
    "penetration_max", "sum_pen2", "iterations_outer", "iterations_inner", "converged", "E_kin", "E_pot", "work_normal",
    "work_friction", "work_rotation", "ledger_defect", "momentum_defect", "speed_max", "omega_max", "wall_s",
)  # fmt: skip

SHOWN = ("steps", "unsolved_steps", "worst_residual", "penetration_max", "ledger_defect", "gaining_steps", "reference_mass")


class Journal:
    """Keeps what every step publishes: ``world.run(10.0, watch=journal)`` or ``world.settle(watch=journal)``.

    rows: one dict a step, under the names of Step.to_dict(). Writing a step's books costs more than a small step itself.
    """

    def __init__(self):
        self.rows, self.notices = [], ()
        self.tolerance = self.reference_mass = None

    def __call__(self, world):
        self.tolerance, self.reference_mass = world.settings.tolerance, world.last_step.reference_mass
        self.notices = world.notices
        self.rows.append(world.last_step.to_dict())

    def __repr__(self):
        return f"<Journal of {len(self.rows)} steps; {str(self).splitlines()[0]}>"

    def _repr_html_(self):
        found = self.summary()
        units = {"penetration_max": "m", "ledger_defect": "J", "reference_mass": "kg"}
        rows = [(name.replace("_", " "), f"{found[name]:.4g}", units.get(name, "")) for name in found if name in SHOWN]
        return table(repr(self), ("quantity", "value", "unit"), rows)

    def plot(self, ax=None):
        """Draw energies and, below, the residual of every step over time. ax: two Axes, new ones where left out; returns them."""
        from minibullet.report import curves

        return curves.run_axes(self, ax)

    def to_dataframe(self):
        """One row a step; columns as in the file, one more for each effect's work [J]."""
        import pandas as pd

        return pd.DataFrame([_flat(row) for row in self.rows])

    def write(self, path):
        """The steps as CSV, whole or not at all; InputError where the file cannot be written."""
        from minibullet.files.writing import replace_file  # what only writes files is not needed to compute

        rows, text = [_flat(row) for row in self.rows], io.StringIO()
        names = dict.fromkeys(name for row in rows for name in row)
        writer = csv.DictWriter(text, fieldnames=list(names), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        replace_file(path, text.getvalue().encode())

    def summary(self):
        """What a run says at its end, as plain numbers: steps, those above the tolerance, the worst of them with its contact,
        deepest penetration [m], the ledger's total defect [J], steps in which contact gave energy, the reference mass [kg], the
        world's notices."""
        if not self.rows:
            return {"steps": 0}
        worst = max(self.rows, key=lambda row: row["residual"])
        return {
            "steps": len(self.rows),
            "tolerance": self.tolerance,
            "unsolved_steps": sum(not row["converged"] for row in self.rows),
            "worst_residual": worst["residual"],
            "worst_step": worst["step"],
            "worst_contact": worst["worst_contact"],
            "penetration_max": max(row["penetration_max"] for row in self.rows),
            "ledger_defect": sum(row["ledger_defect"] for row in self.rows),
            "gaining_steps": sum(_gains(row) for row in self.rows),
            "reference_mass": self.reference_mass,
            "notices": list(self.notices),
        }

    def __str__(self):
        found = self.summary()
        if not found["steps"]:
            return "finished: no step was made"
        text = f"finished: {found['unsolved_steps']} of {found['steps']} steps did not reach residual {found['tolerance']:g}"
        if found["worst_contact"]:
            names = "-".join(found["worst_contact"]["bodies"])
            text += f" (worst {found['worst_residual']:.2g}, step {found['worst_step']}, {names})"
        text += f"; deepest overlap {found['penetration_max']:.2g} m; ledger defect {found['ledger_defect']:.2g} J in all"
        return "\n".join([text, *self.notices])


def _gains(row):
    """Whether contact gave energy in this step, beyond the rounding of its lines."""
    given = row["work_normal"] + row["work_friction"]
    return given > 1e-9 * max(row["E_kin"], *map(abs, row["work_by_effect"].values()), abs(row["work_normal"]))


def _flat(row):
    """One line of a table: plain columns, the worst contact's bodies and point, the work of each effect."""
    contact = row["worst_contact"] or {"bodies": ("", ""), "point": ("", "", "")}
    place = zip(("worst_body_a", "worst_body_b", "worst_x", "worst_y", "worst_z"), (*contact["bodies"], *contact["point"]),
                strict=True)  # fmt: skip
    return {name: row[name] for name in COLUMNS} | dict(place) | {f"work_{k}": v for k, v in row["work_by_effect"].items()}

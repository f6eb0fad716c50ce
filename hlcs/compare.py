"""Compare: where, and by how much, does the model miss the measurement."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hlcs.data.experiment_file import read_experiment_file
from hlcs.data.impacts import as_rows, read_impacts
from hlcs.data.measurement import read_measurement
from hlcs.effects import check_names, own_classes
from hlcs.estimation.trajectory_problem import CHANNELS
from hlcs.kinds.trajectories import judge, prepare


@dataclass(frozen=True)
class Comparison:
    """The model beside the measurement."""

    kind: str
    title: str
    adequate: bool | None  # None where the noise is unknown
    statistic: float | None
    p: float | None
    error: dict  # rms and noise
    where: tuple[dict, ...]
    noise: dict
    notes: tuple[str, ...] = ()
    table: Any = field(default=None, repr=False, compare=False)
    trials: tuple[str, ...] = ()
    impacts: tuple = ()  # of impact_readings.Impact: what the samples around each impact with the floor show
    stated: dict = field(default_factory=dict)  # restitution and friction of the model under test
    against: tuple[str, ...] = ("time", "height", "speed")  # columns of the table that residuals are drawn against
    channels: tuple[str, ...] = CHANNELS  # names of the channels that the table numbers

    def to_json(self):
        """The comparison as a dictionary of plain numbers and texts."""
        from hlcs.selection.diagnosis import plain

        return plain(
            {
                "format": 1,
                "kind": self.kind,
                "title": self.title,
                "adequate": self.adequate,
                "p": self.p,
                "statistic": self.statistic,
                "error": self.error,
                "where": list(self.where),
                "noise": self.noise,
                "impacts": as_rows(self.impacts),
                "notes": list(self.notes),
            }
        )

    def to_dataframe(self):
        """One row an observation: trial, channel, time, height, speed (or its inputs), measured, model, residual, sigmas."""
        import pandas as pd

        frame = pd.DataFrame(self.table or {})
        if "trial" in frame and self.trials:
            frame["trial"] = [self.trials[k] for k in frame["trial"]]
            frame["channel"] = [self.channels[k] for k in frame["channel"]]
        return frame

    def summary(self):
        """The printed report."""
        from hlcs.report.text import comparison_text

        return comparison_text(self)

    def __str__(self):
        return self.summary()

    def _repr_html_(self):
        from hlcs.report.text import fragment

        return fragment(self.title, self.summary())

    def plot(self, ax=None):
        """Residual against time, height and speed, and measured over model; returns the Axes."""
        from hlcs.report.figures import comparison_panels

        return comparison_panels(self, ax)

    def save(self, folder):
        """Write comparison.json, residuals.csv, comparison.txt and comparison.png into a folder; returns it."""
        from hlcs.report.text import save_comparison

        return save_comparison(self, folder)


def compare(path, *others, effects_file=None, seed=0, workers=None, progress=False, allow_outside=False):
    """Where and by how much a model misses a measurement: a Comparison of an experiment file.

    effects_file: Python file with effects of your own that the file names under [model], run as code; seed, workers, progress: of
    the simulations (layer data); allow_outside: let the experiment file name files outside its own folder. With a result and a
    laboratory table in place of a path, the table of layer coefficients beside each other.
    """
    if others or not isinstance(path, str) and not hasattr(path, "__fspath__"):
        from hlcs.placement.comparison import compare_layers

        return compare_layers(path, *others)
    file, own = read_experiment_file(path, allow_outside), own_classes(None, effects_file)
    if file.kind == "layers":
        from hlcs.kinds.layers.diagnosis import compare_layer_file

        return compare_layer_file(file, seed=seed, workers=workers, progress=progress)
    check_names(file, own)  # a misspelt candidate is the user's to mend, though comparing tries none
    measurement = read_measurement(file)
    if file.kind == "outcomes":
        from hlcs.kinds.outcomes import compare_outcomes

        return compare_outcomes(measurement, own)
    return compare_trajectories(measurement, own)


def compare_trajectories(measurement, own=()):
    """The comparison of recordings with the model under test, starts fitted where they are not stated."""
    prepared = prepare(measurement, own)
    noise = {
        "position": prepared.noise.position,
        "orientation": prepared.noise.orientation,
        "rho": prepared.noise.rho,
        "source": prepared.noise.source,
        "flexible": prepared.noise.hint,
    }
    if prepared.problem is None:
        return Comparison(
            measurement.file.kind,
            measurement.file.title,
            None,
            None,
            None,
            {"rms": None, "noise": None, "unit": "m"},
            (),
            noise,
            prepared.notes,
        )
    verdict, table = judge(prepared.problem, prepared.base)
    position = table["channel"] < 3
    unit = "m" if position.any() else "rad"
    inside = position if position.any() else ~position
    error = {
        "rms": float(np.sqrt(np.mean(table["residual"][inside] ** 2))),
        "unit": unit,
        "noise": prepared.noise.position if unit == "m" else prepared.noise.orientation,
        "bias": float(np.mean(-table["residual"][inside])),
    }
    return Comparison(
        measurement.file.kind,
        measurement.file.title,
        verdict.adequate,
        verdict.statistic,
        verdict.p,
        error,
        where_it_fails(prepared.problem, table),
        noise,
        prepared.notes,
        table,
        tuple(trial.name for trial in prepared.problem.trials),
        read_impacts(measurement, prepared.noise),
        {name: getattr(measurement.trials[0].surroundings, name) for name in ("restitution", "friction")},
    )


def where_it_fails(problem, table):
    """Rows {trial, channel, phase, rms, sigma, height, speed, time}, the worst first.

    sigma: root mean square of the residual in units of the noise; height, speed and time where the residual is largest.
    """
    found = []
    phases = table.get("phase", np.full(len(table["trial"]), "flight"))
    names, kind = np.unique(phases, return_inverse=True)
    label = (table["trial"] * 6 + table["channel"]) * len(names) + kind
    order = np.argsort(label, kind="stable")
    for here in np.split(order, np.flatnonzero(np.diff(label[order])) + 1):
        worst = here[np.argmax(np.abs(table["sigmas"][here]))]
        found.append(
            {
                "trial": problem.trials[table["trial"][worst]].name,
                "channel": CHANNELS[table["channel"][worst]],
                "phase": str(phases[worst]),
                "rms": float(np.sqrt(np.mean(table["residual"][here] ** 2))),
                "sigma": float(np.sqrt(np.mean(table["sigmas"][here] ** 2))),
                "time": float(table["time"][worst]),
                "height": float(table["height"][worst]),
                "speed": float(table["speed"][worst]),
            }
        )
    return tuple(sorted(found, key=lambda row: (-row["sigma"], row["trial"], row["channel"], row["phase"])))

"""Layer coefficients of a model beside a measurement: one fixed table, always with the same columns.

print(hlcs.compare(result, hlcs.laboratory("table2", grid="TPG")))
"""

from dataclasses import dataclass

import numpy as np

from hlcs.placement import statistics
from hlcs.placement.placement_result import PlacementResult
from hlcs.placement.printed_tables import LayerTable, laboratory
from hlcs.placement.sea_bottom import Flat, Slope
from hlcs.placement.statistics import Sample
from hlcs.rendering import Result
from minibullet.errors import InputError


@dataclass(frozen=True, eq=False, repr=False)
class LayerComparison(Result):
    """Model and measurement of the same layers, from the first on. Errors are model minus measured: positive = too thick.

    title; model, measured: `hlcs.placement.statistics.Sample` of M layers; notes: what a reader must know to read the table.
    """

    title: str
    model: Sample
    measured: Sample
    notes: tuple[str, ...] = ()

    @property
    def known(self):
        """Layers that both have a coefficient of, boolean (M,): on the others a run found no support for a plate."""
        return np.isfinite(self.model.mean) & np.isfinite(self.measured.mean)

    @property
    def signed_errors(self):
        """(model - measured) / measured of each layer (M,) [-]; nan where one of them is not known."""
        errors = np.full(self.known.shape, np.nan)
        errors[self.known] = statistics.signed_error(*self._both)
        return errors

    @property
    def mean_relative_error(self):
        """The paper's eps_R, Eq. 11 [-], of the known layers; nan where none is."""
        return statistics.mean_relative_error(*self._both) if self.known.any() else np.nan

    @property
    def signed_bias(self):
        """Mean of the signed errors of the known layers [-]; nan where none is."""
        return statistics.signed_bias(*self._both) if self.known.any() else np.nan

    @property
    def height_error(self):
        """Signed relative error of the whole height [-]; nan where a layer is not known."""
        return statistics.height_error(*self._both) if self.known.all() else np.nan

    @property
    def _both(self):
        """The known coefficients, measured and of the model."""
        return self.measured.mean[self.known], self.model.mean[self.known]

    @property
    def z(self):
        """Difference of the means over its standard error (M,); nan where no number of tests or no scatter is known.

        A single model test has no scatter of its own and is given the measurement's: z is then that of one more test.
        """
        measured = self.measured.mean * self.measured.cv
        own = np.where(self.model.tests > 1, self.model.mean * self.model.cv, measured)
        with np.errstate(divide="ignore", invalid="ignore"):
            error = np.sqrt(measured**2 / self.measured.tests + own**2 / self.model.tests)
            return np.where(error > 0.0, (self.model.mean - self.measured.mean) / error, np.nan)

    def to_dict(self):
        """Everything in plain numbers."""
        return {
            "format": 1,
            "kind": "layers",
            "title": self.title,
            "layers": self.layer_rows(),
            "mean_relative_error": self.mean_relative_error,
            "signed_bias": self.signed_bias,
            "height_error": self.height_error,
            "notes": list(self.notes),
        }

    to_json = to_dict

    def layer_rows(self):
        """One dictionary a layer: layer, mean, cv, tests of the model; the measured ones; relative_error, signed_error, z."""
        columns = {
            "layer": np.arange(1, self.model.mean.size + 1),
            **self.model._asdict(),
            **{f"measured_{name}": values for name, values in self.measured._asdict().items()},
            "relative_error": np.abs(self.signed_errors),
            "signed_error": self.signed_errors,
            "z": self.z,
        }
        return [dict(zip(columns, row, strict=True)) for row in zip(*(v.tolist() for v in columns.values()), strict=True)]

    def to_dataframe(self):
        """The rows of `layer_rows`."""
        import pandas as pd

        return pd.DataFrame(self.layer_rows())


def compare_layers(model, measured):
    """Layer coefficients of `model` beside `measured`: a `LayerComparison` of the layers that both have.

    model, measured: a PlacementResult, several of them (repeated tests), a LayerTable, or a Sample. InputError for anything else.
    """
    (name, first), (other, second) = sample_of(model), sample_of(measured)
    layers = min(first.mean.size, second.mean.size)
    notes = []
    if first.mean.size != second.mean.size:
        notes.append(f"layers 1 to {layers} only: the model has {first.mean.size}, the measurement {second.mean.size}")
    if np.any(np.asarray(first.tests) == 1):
        notes.append("one model test: its z takes the measurement's scatter between tests as its own")
    absent = np.flatnonzero(np.isnan(first.mean[:layers])) + 1
    if len(absent):
        notes.append(f"no plate found support on layer {', '.join(map(str, absent))} of the model: left out of the errors")
    return LayerComparison(f"{name} beside {other}", _cut(first, layers), _cut(second, layers), tuple(notes))


def sample_of(thing):
    """(name, Sample with arrays (M,)) of a result, several results, a table or a sample."""
    if isinstance(thing, PlacementResult):
        thing = [thing]
    if isinstance(thing, LayerTable):
        return f"{thing.title} ({thing.source})", Sample(thing.mean, thing.cv, thing.tests)
    if isinstance(thing, Sample):
        mean = np.atleast_1d(np.asarray(thing.mean, dtype=float))
        return "sample", Sample(mean, *(np.broadcast_to(np.asarray(part, dtype=float), mean.shape) for part in thing[1:]))
    if isinstance(thing, list | tuple) and thing and all(isinstance(one, PlacementResult) for one in thing):
        if len({len(one.layer_coefficients) for one in thing}) > 1:
            raise InputError("compare: the results have different numbers of layers; give repeats of one test")
        test = thing[0].test
        name = f"model, {test.grid.name}, {test.shape}, contact friction {test.friction:g}"
        return name, repeated([one.layer_coefficients for one in thing])
    raise InputError(
        f"compare: {type(thing).__name__} has no layer coefficients; give a PlacementResult, a list of them, or a LayerTable"
    )


def repeated(coefficients):
    """The Sample of repeated tests, coefficients (tests, M): mean, CV of single tests about it (nan for one test), number.

    A coefficient that a test does not have (nan) is left out of its layer; a layer that none has is nan, of 0 tests.
    """
    coefficients = np.atleast_2d(np.asarray(coefficients, dtype=float))
    tests = np.isfinite(coefficients).sum(axis=0)
    mean, cv = np.full((2, len(tests)), np.nan)
    some, more = tests > 0, tests > 1
    mean[some] = np.nanmean(coefficients[:, some], axis=0)
    cv[more] = np.nanstd(coefficients[:, more], axis=0, ddof=1) / mean[more]
    return Sample(mean, cv, tests.astype(float))


def laboratory_for(test):
    """The laboratory's table of the same unit, grid and bottom as a PlacementTest, None where it measured no such thing."""
    if test.armour != "cubipod":
        return None
    if isinstance(test.bottom, Flat) and test.grid.name in ("TPG", "RPG"):
        return laboratory("table2", grid=test.grid.name)
    if isinstance(test.bottom, Slope) and test.bottom.grade == 0.04 and test.grid.name == "TPG":
        return laboratory("table3", grid="TPG")
    return None


def _cut(sample, layers):
    return Sample(*(part[:layers] for part in sample))

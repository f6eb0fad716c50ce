"""What was learned of a missing force, or of rebounds, and how it is told."""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from hlcs.data.model_entries import found_entry
from hlcs.files.documents import plain
from hlcs.learning.laws import AXES
from hlcs.rendering import Result
from hlcs.report.words import value
from minibullet.effects.catalogue import defined, module_of
from minibullet.effects.contract import Effect, name_of

FILE = "learned_effect.py"  # name of the effect's file beside a result
QUANTILE = 1.645  # of the normal distribution: intervals of 90 %


@dataclass(frozen=True, repr=False)
class Learned(Result):
    """A law of one variable, of a force or of rebounds, that foretells data it was not fitted to."""

    variable: str
    form: str
    numbers: dict  # name -> {value, low, high, unit}; 90 % intervals
    text: str  # one sentence
    effect_file: str  # the text of a file that `compare` and `diagnose --effects` take; empty where no effect can foretell it
    held_out: dict  # before, after: error of data that the numbers were not fitted to, in their `unit`
    band: dict  # the `quantity` as a table of the variable: grid, value, low, high (k,); as the law has it, where that is no
    # table: places, law (m,); {} of an oscillation
    also: tuple[str, ...]  # other variables that foretell the data as well
    fit: Any = field(default=None, compare=False)  # of the model with the law in it; None where there is no effect
    beside: tuple[dict, ...] = ()  # entries of the effects that it was learned beside, with their numbers in that fit
    remains: dict = field(default_factory=dict)  # what is left with it, as of records.Finding
    folder: str | None = field(default=None, compare=False)  # in which its file lies, where it was written
    quantity: str = "force / mass [m/s2]"  # what the band shows
    unit: str = "m"  # of the error

    @property
    def file_name(self):
        """Name of its file beside a result."""
        return FILE

    def in_folder(self, folder):
        """The same, with its file in this folder."""
        return replace(self, folder=str(folder))

    def place(self, otherwise):
        """The path of its file as it is typed; in the folder `otherwise` where it was not written yet."""
        return str(Path(otherwise if self.folder is None else self.folder) / FILE)

    @cached_property
    def kind(self):
        """The effect class that its file defines."""
        (kind,) = defined(module_of(self.effect_file, "learned_effect", FILE), Effect)
        return kind

    @property
    def entries(self):
        """Entries of [model] effects: of those that it stands beside, and its own behind them: its numbers stand in its file."""
        return (*self.beside, {"name": name_of(self.kind)})

    def to_json(self):
        """The entry `learned` of the result of a diagnosis."""
        file = FILE if self.effect_file else None
        names = ("variable", "form", "quantity", "numbers", "text", "held_out", "band", "also")
        told = {name: getattr(self, name) for name in names}
        return plain(told | {"effect_file": file})


def beside_last(fit):
    """Entries of [model] effects of all effects of a Fit but its last one."""
    constants = {term.name: term.candidate.constants for term in fit.model.terms}
    numbers = {effect: {name: interval(value, 0.0, "1") for name, value in known} for effect, known in constants.items()}
    for (effect, free, found), error in zip(fit.numbers, np.sqrt(np.diag(fit.covariance)), strict=True):
        numbers[effect][free.name] = interval(found, error, free.unit)
    return tuple(found_entry(term.name, numbers[term.name]) for term in fit.model.terms[:-1])


def left_with(problem, fit):
    """What a Fit with the law leaves, as `Learned.remains`."""
    error, names = problem.error(fit.linearization.projected[0]), [term.name for term in fit.model.terms]
    return {"effects": names, "chi2_per_freedom": fit.chi2_per_freedom, "error": error, "foreseen": False}


def interval(value, error, unit):
    """A number with its interval of 90 %; error: its standard deviation."""
    reach = QUANTILE * float(error)
    return {
        "value": float(value),
        "low": float(value) - reach,
        "high": float(value) + reach,
        "unit": "1" if unit == "-" else unit,
    }


def sentence(law, numbers, direction, also, measured=AXES):
    """What a law with these numbers says, in one sentence; direction: along which it acts (3,), None = its own; measured: axes
    along which positions were measured, of which alone a direction or a place is told."""
    others = f" (a law of {' or '.join(also)} does as well)" if also else ""
    if law.form == "oscillation":
        axes = [axis for axis in AXES if f"amplitude_{axis}" in numbers]
        sizes = ", ".join(f"{1000 * numbers[f'amplitude_{axis}']['value']:.2g}" for axis in axes)
        phase = "; its phase differs from recording to recording, so no effect can foretell it" if law.own_phases else ""
        names = " and ".join(", ".join(axes).rsplit(", ", 1))
        told = f"An oscillation of {numbers['frequency_hz']['value']:.2g} Hz"
        return f"{told} in {names} ({sizes} mm): the camera shakes, or a force swings{phase}{others}"
    return f"{_force(law, numbers, direction, measured)} {_grows(law, numbers)}{_strength(law, numbers)}{others}"


def _force(law, numbers, direction, measured):
    """The force, before "that .."."""
    axes = [axis for axis in AXES if axis in measured]
    of_axes = "" if len(axes) == len(AXES) else f" in {' and '.join(axes)}"
    positive = _sign(law, numbers) > 0
    if law.way == "point":
        place = ", ".join(f"{numbers[f'point_{axis}']['value']:.2f}" for axis in axes)
        return f"A {'pull towards' if positive else 'push away from'} ({place}) m{of_axes}"
    if law.way == "velocity":
        return f"A force {'along' if positive else 'against'} the velocity"
    if law.way == "lift":
        return f"A force {'along' if positive else 'against'} spin x velocity"
    parts = [float(direction[AXES.index(axis)]) for axis in axes]
    if len(parts) == 1:
        forwards = parts[0] > 0 if law.way == "axes" else (parts[0] > 0) == positive  # strengths of axes have their signs there
        return f"A force along {'' if forwards else '-'}{axes[0]}"
    return f"A force along ({', '.join(f'{part + 0.0:.2f}' for part in parts)}){of_axes}"


def _strength(law, numbers):
    """How strong the force is, with its interval: that of a power or an exponential where its variable has its reference."""
    strengths = [entry for name, entry in numbers.items() if name.startswith("strength")]
    if not strengths:
        return ""
    total = math.hypot(*(entry["value"] for entry in strengths))
    parts = ((entry["value"], (entry["high"] - entry["low"]) / 2) for entry in strengths)  # errors of axes count as independent
    half = math.hypot(*(size * reach for size, reach in parts)) / total if total else 0.0
    told = value({"value": total, "low": total - half, "high": total + half, "unit": strengths[0]["unit"]})
    at = next((f" at {law.variable} {number.value:g} {number.unit}" for number in law.given if number.name == "reference"), "")
    return f", {told}{at}"


def _sign(law, numbers):
    """Sign of a force along one direction: of its strength, or of the mean of its table."""
    if "mean" in numbers:
        return numbers["mean"]["value"]
    return sum(numbers[number.name]["value"] for number in law.linear if number.name in numbers)


def _grows(law, numbers):
    def told(name, digits=2):
        entry = numbers[name]
        return f"{entry['value']:.{digits}f} +- {(entry['high'] - entry['low']) / 2:.{digits}f}"

    if law.form == "power":
        change = "grows" if numbers["exponent"]["value"] > 0 else "falls"
        return f"that {change} as {law.variable}^{told('exponent')}"
    if law.form == "exponential":
        return f"that changes as exp(k {law.variable}), k = {told('rate')} {numbers['rate']['unit']}"
    if law.form == "switch":
        return f"that acts from {told('start_s')} s to {told('end_s')} s"
    return f"that follows a table of the {law.variable}"

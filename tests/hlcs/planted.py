"""Diagnoses planted by hand, one of every verdict: what a report says of them can be checked word for word."""

from dataclasses import replace

import numpy as np

from hlcs.records import Diagnosis, Finding, NextExperiment, Reason
from hlcs.rendering import Pictures

NOISE = 0.003  # m


def number(value, half, unit="1", **more):
    return {"value": value, "low": value - half, "high": value + half, "unit": unit, **more}


def finding(effect, called, accepted=False, reason=Reason.NOT_SEEN, chi2=None, error=None, **more):
    remains = {} if chi2 is None else {"effects": [effect], "chi2_per_freedom": chi2, "error": error, "foreseen": error is None}
    accepted_reason = Reason.ACCEPTED if accepted else reason
    told = {"fitted": error, "held_out": error, "evidence": 10.0, "accepted": accepted, "called": called, "remains": remains}
    return Finding(effect, **told | {"reason": accepted_reason} | more)


DRAG = finding("quadratic_drag", "air resistance", True, chi2=1.0, error=NOISE)
REBOUND = finding("restitution", "restitution", True, chi2=1.0, error=NOISE)
CLOCK = finding("time_scale", "a clock at a wrong rate", True, chi2=1.0, error=NOISE, lacking=False)
RULER = finding("length_scale", "a wrong scale of length", reason=Reason.NOT_TOLD_APART, chi2=1.0, error=NOISE, lacking=False)
WIND = finding("uniform_flow", "a steady flow of the air", reason=Reason.EXPLAINED_TOO, chi2=40.0)


def table(residual, times=None, trials=4):
    """A table of observations of one channel, as kinds of measurement make it, from residuals (n,) for each of some trials."""
    residual = np.asarray(residual, float)
    times = np.arange(len(residual)) / 100 if times is None else times
    count = len(residual)
    whole = np.tile(residual, trials)
    return {
        "trial": np.repeat(np.arange(trials), count),
        "channel": np.full(count * trials, 2),
        "time": np.tile(times, trials),
        "height": np.tile(5.0 - times, trials),
        "speed": np.tile(times + 1.0, trials),
        "measured": np.tile(times, trials),
        "model": np.tile(times, trials) - whole,
        "residual": whole,
        "sigmas": whole / NOISE,
        "white": whole / NOISE,
    }


def pictures(before, after, trials=4):
    names = tuple(f"drop_{number}.csv" for number in range(trials))
    return Pictures(before, after, names, "time", "time [s]", ("x", "y", "z", "rx", "ry", "rz"), ("m",) * 3 + ("rad",) * 3)


def diagnosis(verdict="effect", found=(DRAG,), others=(WIND,), parameters=None, before=0.15, after=NOISE, **more):
    """A Diagnosis of recordings whose error falls from `before` to `after`."""
    effects = tuple(entry.effect for entry in found)
    chi2 = {"before": (before / NOISE) ** 2, "after": (after / NOISE) ** 2}
    steps = [{"effects": [], "fitted": before, "held_out": before, "chi2_per_freedom": chi2["before"]}]
    if effects:
        steps.append({"effects": list(effects), "fitted": after, "held_out": after, "chi2_per_freedom": chi2["after"]})
    error = {"before": before, "after": after, "noise": NOISE}
    adequate = {
        "before": False,
        "after": verdict != "unexplained",
        "statistic": 1.0,
        "p": 1 / 601,
        "draws": 600,
        "threshold": 3.0,
    }
    told = {
        "kind": "trajectory",
        "title": "a ball",
        "verdict": verdict,
        "effects": effects,
        "parameters": {"quadratic_drag": {"drag_coefficient": number(0.4965, 0.001)}} if parameters is None else parameters,
        "ambiguous": (),
        "error": {"measure": "rms", "unit": "m", "fitted": {**error, "starts": 0.04}, "held_out": error},
        "steps": tuple(steps),
        "adequate": adequate | {"speaks": "variance", "chi2_per_freedom": chi2},
        "candidates": (*found, *others),
        "where": (),
        "next_experiment": None,
        "sets": ({"effects": list(effects), "weight": 1.0, "chi2": 100.0, "held_out": after, "parameters": {}},),
        "explained": 1 - (chi2["after"] - 1) / max(chi2["before"] - 1, 1e-9),
    }
    return Diagnosis(**told | more)


COMPLETE = diagnosis("complete", found=(), parameters={}, before=NOISE)
EFFECT = diagnosis()
AMBIGUOUS = diagnosis(
    "ambiguous",
    found=(CLOCK,),
    others=(RULER, WIND),
    parameters={"time_scale": {"factor": number(1.03, 0.001)}, "length_scale": {"factor": number(1.06, 0.002)}},
    ambiguous=(("time_scale", "length_scale"),),
    sets=tuple(
        {"effects": [name], "weight": 0.5, "chi2": 100.0, "held_out": NOISE, "parameters": {}}
        for name in ("time_scale", "length_scale")
    ),
)
UNEXPLAINED = diagnosis("unexplained", after=0.005)
NOT_JUDGED = replace(
    COMPLETE,
    verdict="cannot_judge",
    error={"measure": "rms", "unit": "m", "fitted": None, "held_out": None},
    adequate={"before": None, "after": None, "statistic": None, "p": None},
    steps=(),
    next_experiment=NextExperiment("record the tracker looking at a body at rest", (), None),
)
ALL = {"complete": COMPLETE, "effect": EFFECT, "ambiguous": AMBIGUOUS, "unexplained": UNEXPLAINED, "cannot_judge": NOT_JUDGED}

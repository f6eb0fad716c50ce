"""The result of a diagnosis: a frozen value that prints, draws, saves and speaks JSON."""

import json
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

VERDICTS = {
    "complete": "nothing is missing at the precision of these data",
    "effect": "missing: {effects}",
    "ambiguous": "one of a set is missing, and these data cannot tell which",
    "unexplained": "the model fails, and no candidate mends it",
    "cannot_judge": "the noise or the number of tests is unknown",
}


@dataclass(frozen=True)
class Finding:
    """What became of one candidate."""

    effect: str
    fitted: float | None  # error with it [unit of the error]
    held_out: float | None
    evidence: float | None  # fall of chi2 less p log n
    accepted: bool
    same_as: tuple[str, ...] = ()
    why: str = ""
    cosines: dict = field(default_factory=dict)
    visible_from: str = ""  # smallest value these data could have shown


@dataclass(frozen=True)
class Diagnosis:
    """The answer of `hlcs.diagnose`; fields as in the result file, plus `model`, the mended model, ready to run."""

    kind: str
    title: str
    verdict: str
    effects: tuple[str, ...]
    parameters: dict  # effect -> name -> {value, low, high, unit}; 90 % intervals
    ambiguous: tuple[tuple[str, ...], ...]
    error: dict
    steps: tuple[dict, ...]
    adequate: dict
    candidates: tuple[Finding, ...]
    where: tuple[dict, ...]
    next_experiment: Any  # NextExperiment or None
    notes: tuple[str, ...] = ()
    noise: dict = field(default_factory=dict)
    model: Any = field(default=None, repr=False)
    pictures: Any = field(default=None, repr=False, compare=False)  # tables the figure draws: before, after

    def to_json(self):
        """The result of `diagnose --json` as a dictionary of plain numbers and texts."""
        following = None
        if self.next_experiment is not None:
            following = {
                "text": self.next_experiment.text,
                "separates": list(self.next_experiment.separates),
                "tests_needed": self.next_experiment.tests_needed,
                "design": self.next_experiment.design,
            }
        findings = []
        for finding in self.candidates:
            entry = asdict(finding)
            entry["same_as"] = list(finding.same_as)
            findings.append(entry)
        return plain(
            {
                "format": 1,
                "kind": self.kind,
                "title": self.title,
                "verdict": self.verdict,
                "effects": list(self.effects),
                "parameters": self.parameters,
                "ambiguous": [list(names) for names in self.ambiguous],
                "error": self.error,
                "steps": list(self.steps),
                "adequate": self.adequate,
                "candidates": findings,
                "where": list(self.where),
                "next_experiment": following,
                "noise": self.noise,
                "notes": list(self.notes),
            }
        )

    def to_dataframe(self):
        """One row a candidate, best first."""
        import pandas as pd

        return pd.DataFrame(
            [
                {
                    "effect": f.effect,
                    "accepted": f.accepted,
                    "evidence": f.evidence,
                    "fitted": f.fitted,
                    "held_out": f.held_out,
                    "same_as": ", ".join(f.same_as),
                    "why": f.why,
                }
                for f in self.candidates
            ]
        )

    def summary(self):
        """The printed report."""
        from hlcs.report.text import diagnosis_text

        return diagnosis_text(self)

    def __str__(self):
        return self.summary()

    def _repr_html_(self):
        from hlcs.report.text import diagnosis_html

        return diagnosis_html(self)

    def plot(self, ax=None):
        """Four panels: fit, residuals, ranking, the error falling to the noise floor; returns the four Axes."""
        from hlcs.report.figures import diagnosis_panels

        return diagnosis_panels(self, ax)

    def save(self, folder):
        """Write result.json, candidates.csv, report.txt, report.html, diagnosis.png, model.toml into a folder; returns it."""
        from hlcs.report.text import save_diagnosis

        return save_diagnosis(self, folder)


def plain(value):
    """The same value in JSON's own types: arrays as lists, non-finite numbers as null."""
    if isinstance(value, dict):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(entry) for entry in value]
    if isinstance(value, np.bool_ | bool):
        return bool(value)
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value


def dumps(diagnosis):
    """The JSON text of a diagnosis."""
    return json.dumps(diagnosis.to_json(), indent=1)

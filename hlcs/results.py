"""Placement results on disk: one folder a run, whole or not there, that loads again and repeats the run."""

import io
import json
from pathlib import Path

import numpy as np

from hlcs import files
from hlcs.placement import LayerRecord
from hlcs.placement_files import SURVEY_FILE, bottom_words, placement_table, read_placement_file, survey_csv
from hlcs.placement_result import PlacementResult
from minibullet.errors import InputError

RECORD_FIELDS = ("reason", "unsettled", "penetration", "transient_penetration", "steps", "unsolved_steps")
ARRAYS, SETTINGS, VALUES = "poses.npz", "settings.toml", "result.json"


def save_placement(result, folder):
    """Write a PlacementResult into a folder, which appears whole; returns its Path."""
    with files.result_folder(folder) as partial:
        write_placement(result, partial)
    return Path(folder)


def write_placement(result, folder):
    """All files of a PlacementResult into an existing, empty folder; elsewhere where that fails, see `files.keep`."""
    from hlcs.placement_report import write_pictures, write_report

    def write(place):
        write_numbers(result, place)
        write_pictures(result, place)
        write_report(result, place)

    files.keep(write, folder, files.to_json(result.to_dict()))


def write_numbers(result, folder):
    """layers.csv, result.json, poses.npz, settings.toml (and the surveyed bed) into an existing folder."""
    files.write_text(folder / "layers.csv", result.to_dataframe().to_csv(index=False))
    records = [{name: getattr(record, name) for name in RECORD_FIELDS} for record in result.records]
    files.write_text(folder / VALUES, files.to_json(result.to_dict() | {"records": records}))
    layers = range(1, len(result.poses) + 1)
    arrays = {f"poses_{j}": poses for j, poses in zip(layers, result.poses, strict=True)}
    arrays |= {f"readings_{j}": readings for j, readings in zip(layers, result.readings, strict=True)}
    content = io.BytesIO()
    np.savez_compressed(content, **arrays)
    files.write_bytes(folder / ARRAYS, content.getvalue())
    files.write_toml(folder / SETTINGS, {"placement": placement_table(result.test)})
    if bottom_words(result.test.bottom) == SURVEY_FILE:
        files.write_text(folder / SURVEY_FILE, survey_csv(result.test.bottom))


def load_placement(folder):
    """The PlacementResult that `save_placement` wrote; InputError where the folder is not one."""
    folder = Path(folder)
    for name in (SETTINGS, VALUES, ARRAYS):
        if not (folder / name).is_file():
            raise InputError(f"folder '{folder}': '{name}' is not there; give a folder that `hlcs place --out` wrote")
    test = read_placement_file(folder / SETTINGS)
    try:
        values = json.loads((folder / VALUES).read_text(encoding="utf-8"))
        with np.load(folder / ARRAYS, allow_pickle=False) as arrays:
            poses = tuple(arrays[f"poses_{j}"] for j in range(1, test.layers + 1))
            readings = tuple(arrays[f"readings_{j}"] for j in range(1, test.layers + 1))
        records = tuple(LayerRecord(layer=j, handles=(), **{name: row[name] for name in RECORD_FIELDS})
                        for j, row in enumerate(values["records"], start=1))
    except (KeyError, ValueError, OSError, TypeError) as problem:
        raise InputError(f"folder '{folder}': not a whole placement result ({problem}); run the test again") from None
    return PlacementResult(test, readings, poses, records, float(values["wall_seconds"]))

"""Placement results on disk: one folder a run, whole or not there, that loads again and repeats the run."""

import io
import json
from pathlib import Path

import numpy as np

from hlcs.files import folders
from hlcs.files.spreadsheets import as_columns, csv_text
from hlcs.placement import metres
from hlcs.placement.layer_placement import LayerRecord
from hlcs.placement.placement_file import read_placement_file
from hlcs.placement.placement_result import PlacementResult
from hlcs.placement.settings_table import STANDING_FILE, SURVEY_FILE, UNIT_FILE, bottom_words, placement_table
from minibullet.errors import InputError, is_number
from minibullet.files.arrays import ArrayFile
from minibullet.files.reading import read_text

RECORD_FIELDS = ("reason", "unsettled", "penetration", "transient_penetration", "steps", "unsolved_steps")
LATER_FIELDS = ("lifted", "mean_lift", "pushed", "redrawn", "added", "covered")  # which results of earlier versions lack
LATER_ARRAYS = {  # of each layer, which results of earlier versions lack: kind and lengths as `ArrayFile.take` wants them
    "aims": (float, ("units of layer {}", 2)),
    "plates": (float, ("plates on layer {}", 3)),
    "standing": (int, ("units of layer {}",)),  # 1: stands
}
MOST_BYTES = 400_000_000  # of a file of a result, unpacked: seven million poses, more than any machine has placed
ARRAYS, SETTINGS, VALUES = "poses.npz", "settings.toml", "result.json"


def write_numbers(result, folder):
    """layers.csv, units.csv, crest_profile.csv, result.json, poses.npz, settings.toml and the files that it names, into an
    existing folder."""
    folders.write_text(folder / "layers.csv", csv_text(as_columns(result.layer_rows())))
    folders.write_text(folder / "units.csv", csv_text(as_columns(metres.unit_rows(result))))
    folders.write_text(folder / "crest_profile.csv", csv_text(metres.crest_profile(result)))
    records = [{name: getattr(record, name) for name in RECORD_FIELDS + LATER_FIELDS} for record in result.records]
    folders.write_text(folder / VALUES, folders.to_json(result.to_dict() | {"records": records}))
    layers = range(1, len(result.poses) + 1)
    arrays = {f"poses_{j}": poses for j, poses in zip(layers, result.poses, strict=True)}
    arrays |= {f"readings_{j}": readings for j, readings in zip(layers, result.readings, strict=True)}
    for name, (kind, _) in LATER_ARRAYS.items():
        arrays |= {f"{name}_{j}": values.astype(kind) for j, values in enumerate(getattr(result, name), start=1)}
    content = io.BytesIO()
    np.savez_compressed(content, **arrays)
    folders.write_bytes(folder / ARRAYS, content.getvalue())
    folders.write_toml(folder / SETTINGS, {"placement": placement_table(result.test)})
    if bottom_words(result.test.bottom) == SURVEY_FILE:
        folders.write_text(folder / SURVEY_FILE, result.test.bottom.csv_text())
    if not isinstance(result.test.armour, str):
        result.test.armour.write(folder / UNIT_FILE)
    if result.test.standing:
        result.test.standing.write(folder / STANDING_FILE)


def load_placement(folder):
    """The PlacementResult that `write_numbers` wrote; InputError where the folder is not one."""
    folder = Path(folder)
    for name in (SETTINGS, VALUES, ARRAYS):
        if not (folder / name).is_file():
            raise InputError(f"folder '{folder}': '{name}' is not there; give a folder that `hlcs place --out` wrote")
    test = read_placement_file(folder / SETTINGS)
    remedy = "not a whole placement result, run the test again"
    arrays = ArrayFile(folder / ARRAYS, f"folder '{folder}': '{ARRAYS}'", MOST_BYTES, remedy, packed=True)
    poses = tuple(arrays.take(f"poses_{j}", float, (f"units of layer {j}", 7)) for j in range(1, test.layers + 1))
    readings = tuple(arrays.take(f"readings_{j}", float, (f"plates on layer {j}",)) for j in range(1, test.layers + 1))
    later = {
        name: tuple(
            arrays.take(f"{name}_{j}", kind, _of_layer(shape, j)) for j in range(1, test.layers + 1) if f"{name}_{j}" in arrays
        )
        for name, (kind, shape) in LATER_ARRAYS.items()
    }
    for j, layer in enumerate(poses, start=1):
        if not len(layer) or not np.isfinite(layer).all():
            arrays.fail(f"poses_{j} has no rows, or a value that is not finite")
    text = read_text(folder / VALUES, f"folder '{folder}': '{VALUES}'", MOST_BYTES, remedy)
    try:
        values = json.loads(text)
        records = tuple(
            LayerRecord(
                layer=j,
                handles=(),
                **{name: row[name] for name in RECORD_FIELDS},
                **{name: row[name] for name in LATER_FIELDS if name in row},
            )
            for j, row in enumerate(values["records"], start=1)
        )
        carried_by = tuple(tuple(row["carried_by"]) for row in values.get("plates", ()))
        notices = tuple(map(str, values.get("notices", ())))
        seconds = float(values["wall_seconds"])
        numbers = RECORD_FIELDS[1:] + LATER_FIELDS
        if len(records) != test.layers or not all(is_number(getattr(r, name)) for r in records for name in numbers):
            raise ValueError(f"'records' must tell of {test.layers} layers, in numbers")
    except (LookupError, ValueError, TypeError, OverflowError, RecursionError) as problem:
        raise InputError(f"folder '{folder}': not a whole placement result ({problem}); run the test again") from None
    standing = tuple(stands.astype(bool) for stands in later["standing"])
    return PlacementResult(test, readings, poses, records, seconds, carried_by, later["aims"], notices, later["plates"], standing)


def _of_layer(shape, layer):
    """Lengths of an array, their words with the number of the layer."""
    return tuple(length.format(layer) if isinstance(length, str) else length for length in shape)

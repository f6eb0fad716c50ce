"""An experiment as users have it in hand: what was measured and the model under test, from a file or put together in Python.

e = hlcs.Experiment.read("drop.toml")
hlcs.compare(e, effects=[mb.QuadraticDrag(drag_coefficient=0.47)])
hlcs.diagnose(e).apply(e).save("drop_2.toml")
"""

import copy
import os
import shlex
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from hlcs.data.effects_of_model import OF_EFFECTS
from hlcs.data.experiment_file import SECTIONS, ExperimentFile, checked_experiment, read_experiment_file
from hlcs.data.frames import csv_of, frames_in, what_is
from hlcs.data.model_entries import MODEL
from hlcs.effects import classes, entry_of, own_classes
from hlcs.files import folders
from hlcs.files.csv_files import MOST_BYTES, CsvText
from hlcs.files.documents import toml_value, toml_values
from hlcs.files.toml_edit import with_values
from hlcs.files.toml_files import TomlFile
from hlcs.kinds import KINDS
from minibullet.errors import InputError, shown_value
from minibullet.files.reading import read_bytes
from minibullet.values import table as html_table

MADE = "# Written by hlcs from "  # how a file begins that may be written again while its mark fits
COMMENTS_STAY = "; comments stay there"  # in that line, where they could not be kept
IN_PYTHON = "frames"  # what messages call an experiment that stands in no file


@dataclass(frozen=True, eq=False, repr=False)
class Experiment:
    """A measurement and the model under test: a value that `compare` and `diagnose` take; changes make another one.

    file: what it says, read and checked; user_effects: effect classes of the user's own that it may name; effects_file: the
    Python file that these come from, None where there is none.
    """

    file: ExperimentFile
    user_effects: tuple[type, ...] = ()
    effects_file: str | None = None
    effects_text: str = ""  # of `effects_file` where that is still to be written, beside the experiment file

    @classmethod
    def read(cls, path, allow_outside=False, effects_file=None):
        """The Experiment of a file; an Experiment is itself.

        path: of the file; allow_outside: let the file name files outside its own folder; effects_file: Python file with effects
        of your own, run as code. Raises InputError naming file, line, key, value and remedy.
        """
        own = own_classes(None, effects_file)
        if isinstance(path, Experiment):
            return path if effects_file is None else replace(path.with_user_effects(own), effects_file=str(effects_file))
        if not isinstance(path, str | os.PathLike):
            told = f"experiment: got {what_is(path)}; give the path of an experiment file, or an hlcs.Experiment"
            raise InputError(told + " (hlcs.Experiment.from_frames makes one of tables)")
        file = read_experiment_file(path, allow_outside, _layouts())
        return cls(file, own, effects_file and str(effects_file))

    @classmethod
    def from_frames(
        cls, frames, body=None, surroundings=None, noise=None, static=None, trials=None, kind="trajectory", title="", **sections
    ):
        """The Experiment of tables in memory, without any file.

        frames: one for each recording, or the one table of kind "outcomes" or "layers", with the columns of the CSV files: pandas
        frames, dictionaries of arrays or lists, structured arrays; body, surroundings, noise: as in an experiment file; static:
        frame of a body at rest; trials: what stands beside each frame, [{"group": .., "start": ..}, ..]; kind; title; sections:
        others of an experiment file (model, diagnose, measurement, placement), as dictionaries. Raises InputError as `read`,
        where a frame is called "frame 1" and its rows are numbered by its index.
        """
        texts = [csv_of(frame, f"frame {k}") for k, frame in enumerate(frames_in(frames), start=1)]
        tables, measurement = {text.name: text for text in texts}, _measurement(sections, noise, static)
        values = {"kind": kind, "title": title or IN_PYTHON, "body": body, "surroundings": surroundings, **sections}
        if not isinstance(kind, str) or kind not in KINDS or KINDS[kind].layout.in_trials:
            values["trial"] = _trial_tables(list(tables), trials)
        elif trials is not None:
            raise InputError(
                f'{IN_PYTHON}: trials stand beside recordings; kind = "{kind}" takes columns of its one frame instead'
            )
        elif len(tables) == 1:
            measurement["file"] = next(iter(tables))
        else:
            raise InputError(f'{IN_PYTHON}: {len(tables)} frames; kind = "{kind}" takes one, with a row for each experiment')
        if static is not None:
            tables["static"], measurement["static"] = csv_of(static, "static"), "static"
        values["measurement"] = _given(measurement)
        try:
            values = toml_values(_given(values))
        except TypeError as problem:
            raise InputError(f"{IN_PYTHON}: {problem}; give numbers, texts, lists and dictionaries") from None
        return cls(checked_experiment(TomlFile.of_values(IN_PYTHON, values, SECTIONS, tables), _layouts()))

    def __repr__(self):
        names = ", ".join(entry["name"] for entry in self.file.effects) or "none"
        return f"Experiment: {self.file.title} ({self.file.kind}); effects in its model: {names}"

    def _repr_html_(self):
        entries = ({key: value for key, value in entry.items() if key != "name"} for entry in self.file.effects)
        numbers = (", ".join(f"{key} = {value}" for key, value in entry.items()) for entry in entries)
        rows = [(entry["name"], told) for entry, told in zip(self.file.effects, numbers, strict=True)]
        return html_table(repr(self), ("effect in the model", "numbers"), rows)

    def opened(self, options):
        """The experiment opened by its kind (`kinds.protocol`), its data read and checked; options: of `kinds.protocol`."""
        return KINDS[self.file.kind](self.file, options)

    # --- other models -----------------------------------------------------------------------------------------------------------

    def with_effects(self, effects, user_effects=()):
        """Another Experiment with these effects added to its model; where it holds one of that name, the new one takes its place.

        effects: values such as `minibullet.QuadraticDrag`(drag_coefficient=0.47), or entries of `effects`; user_effects:
        classes of the user's own that entries name.
        """
        if isinstance(effects, str | dict) or not isinstance(effects, Iterable):
            raise InputError(
                f"effects: got {shown_value(effects)}; give a list, such as [minibullet.QuadraticDrag(drag_coefficient=0.47)]"
            )
        effects, shipped = list(effects), {dict, *classes().values()}
        entries = [entry_of(effect) for effect in effects]
        own = own_classes([type(effect) for effect in effects if type(effect) not in shipped])
        names = [entry["name"] for entry in entries]
        kept = [entry for entry in self.file.effects if entry["name"] not in names]
        return self.with_user_effects((*own, *user_effects))._with_entries([*kept, *entries], names)

    def with_model(self, model):
        """Another Experiment with this model, such as `diagnosis.model`, in place of its own."""
        entries = getattr(model, "entries", None)
        if entries is None:
            raise InputError(f"{type(model).__name__} is no model of an experiment; give diagnosis.model, or effects=[..]")
        added = [entry["name"] for entry in entries if entry not in self.file.effects]
        return self.with_user_effects(getattr(model, "own", ()))._with_entries(entries, added)

    def with_user_effects(self, kinds):
        """The same, with more classes of the user's own to look names up."""
        return replace(self, user_effects=tuple(dict.fromkeys((*self.user_effects, *kinds))))

    def with_effects_text(self, name, text):
        """The same with an effects file of this name and text, which is written beside it when it is saved."""
        return replace(self, effects_file=name, effects_text=text)

    def before(self):
        """The Experiment without the effects that were added last, what they replaced in its place; None where the file names
        none."""
        added, replaced = self.file.added, {entry["name"]: entry for entry in self.file.replaced}
        entries = [
            replaced.get(entry["name"], entry) for entry in self.file.effects if entry["name"] not in {*added} - {*replaced}
        ]
        return self._with_entries(entries, ()) if added else None

    def _with_entries(self, entries, added):
        """The same with these entries of [model] effects, of which some were added."""
        values = self.file.source.values
        replaced = [dict(entry) for entry in self.file.effects if entry["name"] in added and entry not in entries]
        model = {key: value for key, value in values.get("model", {}).items() if key not in OF_EFFECTS}
        model |= {"effects": [dict(entry) for entry in entries]} | ({"added": list(added)} if added else {})
        model |= {"replaced": replaced} if replaced else {}
        file = checked_experiment(self.file.source.with_values({**values, "model": model}), _layouts())
        return replace(self, file=file)

    # --- files ------------------------------------------------------------------------------------------------------------------

    @property
    def command(self):
        """The command that compares it, as it is typed; "" where it stands in no file."""
        return self.typed("compare")

    def typed(self, verb):
        """The command that compares or diagnoses it, as it is typed; "" where it stands in no file."""
        path = self.file.path
        if self.file.source.tables:
            return ""
        words = ["hlcs", verb, str(path)]
        below = Path(os.path.realpath(path.parent))
        if not all(Path(os.path.realpath(place)).is_relative_to(below) for place in self._data_files()):
            words.append("--allow-outside")
        return shlex.join(words + (["--effects", self.effects_file] if self.effects_file else []))

    def save(self, path):
        """Write it as an experiment file that names its data from there; frames are written beside it as CSV files.

        Returns the Experiment of that file. It keeps the comments of the file that it was read from, where [model] stands in that
        under a title of its own, or nowhere. Raises InputError where another file of that name stands there, or one that was
        changed since it was written, or none can be written.
        """
        path, found = folders.path_of(path), {}
        check_target(path, self.file.path)

        def name_of(name):
            if name in self.file.source.tables:
                found[f"{path.stem}_{name.replace(' ', '_')}.csv"] = self.file.source.tables[name].text.encode()
                return next(reversed(found))
            return Path(os.path.relpath(self.file.path.parent / name, path.parent)).as_posix()

        text = self._text(name_of)
        if COMMENTS_STAY in text.partition("\n")[0]:
            check_target(path, None)
        if self.effects_text:
            found[self.effects_file] = self.effects_text.encode()
        for place in (path.parent / name for name in found):
            if place.exists() and not path.exists() and _bytes_of(place) != found[place.name]:
                raise InputError(
                    f"'{place}' is there already, and what '{path}' needs would be written to it; move it, or give another folder"
                )
        for name, content in found.items():
            folders.write_bytes(path.parent / name, content)
        folders.write_text(path, text)
        written = {"effects_file": str(path.parent / self.effects_file), "effects_text": ""} if self.effects_text else {}
        return replace(self, file=read_experiment_file(path, True, _layouts()), **written)

    def files(self, folder, taken):
        """{name: bytes} of MODEL, its experiment file in a folder of results, and of the data that lie elsewhere, so that
        the file can be used as it is; taken: names of other files there."""
        below, found = Path(os.path.realpath(folder)), {}

        def name_of(name):
            table = self.file.source.tables.get(name)
            place = Path(os.path.realpath(self.file.path.parent / name))
            if table is None and place.is_relative_to(below):
                return place.relative_to(below).as_posix()
            content = _bytes_of(table or place)
            wanted = f"{name.replace(' ', '_')}.csv" if table else place.name
            free = (f"{number}_{wanted}" if number else wanted for number in range(len(found) + 2))
            own = next(one for one in free if one not in (*taken, MODEL) and found.get(one, content) == content)
            found[own] = content
            return own

        text = self._text(name_of)
        return found | {MODEL: text.encode()}

    def _text(self, name_of):
        """Its experiment file; name_of: function name of a data file -> name that it is to have."""
        document, places = _named_files(self.file.source.values)
        for table, key in places:
            table[key] = name_of(table[key])
        kept = self._kept_text(document)
        if kept:
            return _marked(self.file.path.name, kept)
        ordered = {section: document[section] for section in SECTIONS[""] if section in document}
        whence = "frames in Python" if self.file.source.tables else f"{self.file.path.name}{COMMENTS_STAY}"
        return _marked(whence, folders.to_toml(ordered, inline=True))

    def _kept_text(self, document):
        """The text that it was read from with another [model] and other names of data files; "" where that does not say what the
        document says: its tables stand in another form, or there is no text."""
        source = self.file.source
        first, _, rest = source.text.partition("\n")
        text = rest if first.startswith(MADE) else source.text
        for (table, key), (was, name) in zip(_named_files(document)[1], _named_files(source.values)[1], strict=True):
            if table[key] != was[name]:
                text = text.replace(toml_value(was[name]), toml_value(table[key]))
        model = {key: document.get("model", {}).get(key) for key in OF_EFFECTS}
        text = with_values(text, "model", model, ("measurement", "diagnose", "trial"))
        try:
            return text if tomllib.loads(text) == document else ""
        except tomllib.TOMLDecodeError:
            return ""

    def _data_files(self):
        """The paths of all files that it names."""
        return [self.file.path.parent / table[key] for table, key in _named_files(self.file.source.values)[1]]


def check_target(path, source):
    """InputError where no experiment file can be written, see `hlcs.files.folders.check_file`, or where what somebody changed in
    one would be lost; source: the file that it is made from, whose own changes it keeps, None where it keeps none."""
    folders.check_file(path, MADE, "an experiment file")
    path = folders.path_of(path)
    if not path.exists() or source is not None and os.path.realpath(path) == os.path.realpath(source):
        return
    first, _, rest = read_bytes(path, str(path), MOST_BYTES, "give another name").partition(b"\n")
    if first and not first.endswith(_mark(rest).encode()):
        told = "is not as this program wrote it" if b"(mark " in first else "is of an earlier version, or not as it was written"
        raise InputError(f"'{path}' {told}: what was changed in it would be lost; give another name")


def _marked(whence, text):
    """The text of a file that may be written again while it is as it was written: its first line says so of the rest."""
    return f"{MADE}{whence} {_mark(text.encode())}\n{text}"


def _mark(content):
    """What tells whether bytes are still as they were written."""
    return f"(mark {folders.mark(content)[1][:16]})"


def _named_files(values):
    """(copy of the values of an experiment file, [(table, key)] of every place in it that names a file)."""
    values = copy.deepcopy(values)
    trials = values.get("trial", [])
    bodies = [values.get("body", {}), *trials, *(trial.get("body", {}) for trial in trials)]
    places = [(values.get("measurement", {}), key) for key in ("static", "file")]
    places += [(trial, "file") for trial in trials] + [(body, "mesh") for body in bodies]
    if str(values.get("placement", {}).get("bottom", "")).strip().lower().endswith(".csv"):
        places.append((values["placement"], "bottom"))
    return values, [(table, key) for table, key in places if key in table]


def _bytes_of(data):
    """The content of a data file, or of a table in memory."""
    return data.text.encode() if isinstance(data, CsvText) else read_bytes(data, str(data), MOST_BYTES, "thin the rows out")


def _measurement(sections, noise, static):
    """The [measurement] section of `from_frames`; InputError where something is given twice."""
    if "trial" in sections:
        raise InputError("trial: frames have none; give trials=[{..}, ..], a dictionary for each frame")
    stated = sections.get("measurement")
    if stated is not None and not isinstance(stated, dict):
        raise InputError(f"measurement: got {shown_value(stated)}; give a dictionary, such as {{'planar': True}}")
    measurement = dict(stated or {})
    for key, given, place in (("noise", noise, "noise=.."), ("static", static, "static=.."), ("file", ..., "the frame")):
        if given is not None and measurement.get(key) is not None:
            raise InputError(f"measurement: {key} = {shown_value(measurement[key])} beside {place}; give one of them")
    return measurement if noise is None else measurement | {"noise": noise}


def _trial_tables(names, trials):
    """The [[trial]] tables of frames of these names."""
    several = isinstance(trials, Iterable) and not isinstance(trials, dict | str)
    trials = [{} for _ in names] if trials is None else list(trials) if several else [trials]
    for trial in trials:
        if not isinstance(trial, dict):
            raise InputError(
                f"trials: got {shown_value(trial)}; give a list of one dictionary for each frame, such as {{'group': 'a'}}"
            )
    if len(trials) != len(names):
        raise InputError(f"{IN_PYTHON}: {len(trials)} trials for {len(names)} frames; give one dictionary for each frame")
    return [{"file": name, **trial} for name, trial in zip(names, trials, strict=True)]


def _given(table):
    """What is given of a table: None is left out."""
    return {key: value for key, value in table.items() if value is not None}


def _layouts():
    """{kind: Layout} of all kinds of measurement."""
    return {name: kind.layout for name, kind in KINDS.items()}

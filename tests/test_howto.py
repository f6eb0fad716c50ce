"""The how-to pages: their snippets run, their commands work, and print what the pages show."""

import glob
import re
import shlex
from pathlib import Path

import pytest

from hlcs.cli import commands
from hlcs.importing import FORMATS

PAGES = sorted(path for path in (Path(__file__).resolve().parent.parent / "docs" / "howto").glob("*.md") if path.stem != "index")
IMPORTS = [page for page in PAGES if "hlcs import " in page.read_text(encoding="utf-8")]
VERDICTS = [page for page in PAGES if page not in IMPORTS]
NUMBER = re.compile(r"[-<>]?\d+(\.\d+)?(e[-+]\d+)?| +")  # and the spaces that line numbers up
BLOCK = re.compile(r"^```(python|bash|toml|text)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def walk(page, capsys, until=None):
    """Follow a page in the current folder: run its python and bash, write its toml where a comment names the file or
    else fill it in, and compare its text with what was printed.

    until: word of a command before which to stop. Returns the number of blocks of text that were compared. Of a page that drops
    units the words are compared, not the numbers: in a pile the last bit grows, and another processor rounds it otherwise.
    """
    printed, experiment, compared, names = "", None, 0, {}
    whole = page.read_text(encoding="utf-8")
    said = (lambda line: NUMBER.sub("", line)) if "hlcs design " in whole or "hlcs place " in whole else str
    for kind, text in BLOCK.findall(whole):
        if kind == "python":
            exec(text, names)  # a page of this repository, not a user's file; its snippets follow each other
        elif kind == "toml" and (named := re.match(r"# (\w+\.toml)\n", text)):
            Path(named[1]).write_text(text, encoding="utf-8")
        elif kind == "toml":
            lines = experiment.read_text(encoding="utf-8").split("\n")
            for line in filter(None, text.split("\n")):
                if line.startswith("["):  # the lines below it stand under this heading in the file, which has it once
                    begin = lines.index(line)
                    assert lines.count(line) == 1
                else:
                    (place,) = [k for k, old in enumerate(lines) if old.startswith(line.split(" = ")[0] + " = ")]
                    assert [old for old in lines[: place + 1] if old.startswith("[")][-1] == lines[begin]
                    lines[place] = line
            experiment.write_text("\n".join(lines), encoding="utf-8")
        elif kind == "bash":
            if until and until in text:
                return compared
            printed = ""
            for line in filter(None, text.split("\n")):
                words = [word for one in shlex.split(line)[1:] for word in (sorted(glob.glob(one)) if "*" in one else [one])]
                assert commands.main(words) == 0, capsys.readouterr().err
                printed += capsys.readouterr().out
                experiment = Path(words[-1]) / "experiment.toml" if words[0] == "import" else experiment
        else:
            shown = [line for line in text.split("\n") if line.strip() and line.strip() != ".."]
            there = {said(line) for line in printed.split("\n")}
            assert not [line for line in shown if said(line) not in there], printed
            compared += 1
    return compared


@pytest.mark.parametrize("page", IMPORTS, ids=lambda path: path.stem)
def test_the_import_on_a_page_prints_what_the_page_shows(page, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert walk(page, capsys, until="compare") == 1


@pytest.mark.slow
@pytest.mark.parametrize("page", IMPORTS, ids=lambda path: path.stem)
def test_a_page_leads_from_the_export_to_the_mended_model(page, capsys, tmp_path, monkeypatch):
    """Every figure on the page is what the commands print; the last comparison leaves nothing but noise."""
    monkeypatch.chdir(tmp_path)
    assert walk(page, capsys) == 3
    assert "nothing but noise" in page.read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("page", VERDICTS, ids=lambda path: path.stem)
def test_a_page_shows_what_its_commands_print(page, capsys, tmp_path, monkeypatch):
    """From the first verdict to the last: every line that is shown stands in what was printed."""
    monkeypatch.chdir(tmp_path)
    assert walk(page, capsys) == len(re.findall("^```text$", page.read_text(encoding="utf-8"), re.MULTILINE)) >= 1


def test_the_table_of_options_says_which_formats_listen_to_them():
    """Each row `--name` | .. | formats agrees with the USES of the readers."""
    text = (PAGES[0].parent / "index.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `--([\w-]+) [^|]*\| [^|]+ \| ([\w, ]+) \|$", text, re.MULTILINE)
    said = {name.replace("-", "_"): set(FORMATS) if which == "all" else set(which.split(", ")) for name, which in rows}
    assert said == {name: {form for form, reader in FORMATS.items() if name in reader.USES} for name in said}
    assert set(said) == {name for reader in FORMATS.values() for name in reader.USES}

"""The command as the tests of this folder run it."""

import pytest

from hlcs.cli import commands


@pytest.fixture
def hlcs(capsys, tmp_path, monkeypatch):
    """Run the command in an empty folder; returns (status, stdout, stderr)."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        status = commands.main(list(arguments))
        output = capsys.readouterr()
        return status, output.out, output.err

    return run

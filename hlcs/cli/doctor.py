"""`hlcs doctor`: is everything there, and does it work."""

import click

from hlcs.cli import self_test
from hlcs.cli.options import example, out_folder, output_options, publish
from hlcs.files import folders


@click.command()
@output_options
@example("hlcs doctor")
def doctor(out, json_file, quiet):
    """Versions, optional parts, and a short self-test.

    The self-test asks the collision library, the engine, and one small placement test. It takes some seconds; where the
    engine is not compiled yet, about a minute of computing, two on a slow machine. Exit status 1 if it fails.
    """
    report = self_test.examine()
    with out_folder(out) as folder:
        if folder:
            folders.write_json(folder / "doctor.json", report)
    publish(report, self_test.text_of(report), json_file, out, quiet)
    return 0 if report["passed"] else 1

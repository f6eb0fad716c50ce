"""`hlcs demo` and `hlcs place`: one placement test."""

import click

from hlcs.cli.options import ProgressBar, allow_outside_option, example, out_folder, output_options, preset_option, publish
from hlcs.cli.placement_options import placement_options
from hlcs.placement import report
from hlcs.placement.comparison import compare_layers, laboratory_for
from hlcs.placement.placement_file import make_placement, read_placement_file
from hlcs.placement.presets import preset
from hlcs.placement.procedure import PlacementTest
from hlcs.processes.compilation import compile_engine


@click.command()
@output_options
@click.option("--seed", type=int, default=1, show_default=True, help="of the orientations")
@example("hlcs demo --out out")
def demo(seed, out, json_file, quiet):
    """The main job in under a minute, beside the laboratory.

    A five-layer placement test of Cubipods on the triangular grid, with the default settings (the paper's own
    are others: `hlcs place --preset paper`). In --out: layers.csv, units.csv (every unit: position, heading, state),
    crest_profile.csv, result.json, report.html (one file, opens offline), scene.glb, structure.png, top_view.svg (to
    scale), poses.npz, and settings.toml, which `hlcs place` repeats exactly.
    """
    _place(PlacementTest(seed=seed), out, json_file, quiet)


@click.command()
@click.argument("file", required=False, metavar="[TEST.toml]")
@placement_options
@preset_option
@allow_outside_option
@output_options
@example("hlcs place --grid RPG --layers 3 --friction 0.36 --out out", "hlcs place out/settings.toml")
def place(file, preset_name, allow_outside, out, json_file, quiet, **settings):
    """One placement test, from a file, options, or both.

    TEST.toml has a table [placement] with the names below, such as falling_distance = 0.25. Options win over it, and both
    over a preset.
    """
    given = preset(preset_name)
    if file:
        test = read_placement_file(file, allow_outside, given, **settings)
    else:
        test = make_placement({**given, **settings})
    _place(test, out, json_file, quiet)


def _place(test, out, json_file, quiet):
    """Run a test, print it beside the laboratory's, write its files."""
    measured = laboratory_for(test)
    with out_folder(out) as folder:
        compile_engine(quiet)
        with ProgressBar("layers", test.layers, quiet) as bar:
            result = test.run(progress=lambda layer: bar.update())
        if folder:
            report.write(result, folder)
    text = result.summary()
    if measured is not None:
        text += f"\n\n{compare_layers(result, measured)}"
    publish(result.to_dict(), text, json_file, out, quiet)

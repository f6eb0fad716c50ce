"""The command `hlcs`: thin wrappers round the package's functions. Work and words live elsewhere.

Exit statuses are the business of `hlcs.cli.error_handling`. A verdict is a result: 0.
"""

import importlib
import keyword
from collections import UserDict

import click

from hlcs.cli import error_handling


class CommandModules(UserDict):
    """Commands by name; each is loaded from its module, the value here, when it is asked for."""

    def __getitem__(self, name):
        function = f"{name}_" if keyword.iskeyword(name) else name  # no function can be called `import`
        return getattr(importlib.import_module(f"hlcs.cli.{self.data[name]}"), function)


COMMANDS = CommandModules(
    compare="experiments",
    course="course",
    demo="place",
    design="design",
    diagnose="experiments",
    doctor="doctor",
    effects="effects",
    **{"import": "importing"},
    mystery="mystery",
    place="place",
    plan="plan",
    reproduce="reproduce",
    sweep="sweep",
)


@click.group(commands=COMMANDS, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="hlcs")
def commands():
    """Place concrete armour units on a computer, compare with the laboratory, and find what the model is missing."""


def run(arguments=None):
    """Run the command; returns what the commands return, raises what they raise."""
    return commands.main(args=arguments, prog_name="hlcs", standalone_mode=False)


def main(arguments=None):
    """Run the command, its errors handled; returns the exit status."""
    return error_handling.handled(lambda: run(arguments))

"""The command `hlcs`: thin wrappers round the package's functions. Work and words live elsewhere.

Exit statuses are the business of `hlcs.cli.error_handling`. A verdict is a result: 0.
"""

import ast
import importlib
import keyword
from collections import UserDict
from importlib.util import find_spec

import click

from hlcs.cli import error_handling


class CommandModules(UserDict):
    """Commands by name; each is loaded from its module, the value here, when it is asked for."""

    def __getitem__(self, name):
        return getattr(importlib.import_module(self.module(name)), self.function(name))

    def module(self, name):
        """Name of the module of a command."""
        return f"hlcs.cli.{self.data[name]}"

    def function(self, name):
        """Name of the function of a command: none can be called `import`."""
        return f"{name}_" if keyword.iskeyword(name) else name

    def summary(self, name):
        """First line of the docstring of a command, read from the text of its module: to load them all takes over a second."""
        text = find_spec(self.module(name)).loader.get_source(self.module(name))
        functions = {node.name: node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)}
        return ast.get_docstring(functions[self.function(name)]).splitlines()[0]


class Group(click.Group):
    """A group that lists its commands without loading them."""

    def format_commands(self, context, formatter):
        """Write the names of the commands and what each does."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, self.commands.summary(name)) for name in self.list_commands(context)])


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


@click.group(cls=Group, commands=COMMANDS, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="hlcs")
def commands():
    """Place concrete armour units on a computer, compare with the laboratory, and find what the model is missing."""


def run(arguments=None):
    """Run the command; returns what the commands return, raises what they raise."""
    return commands.main(args=arguments, prog_name="hlcs", standalone_mode=False)


def main(arguments=None):
    """Run the command, its errors handled; returns the exit status."""
    return error_handling.handled(lambda: run(arguments))

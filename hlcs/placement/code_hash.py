"""Which code made a result: a hash of every module that can change it, and of the versions of the libraries below them.

The modules are not listed anywhere. They are found by following the imports from the module that computes: what stands at the top
of a module is needed to compute with it; what is imported inside a function (reports, pictures, files) is not.
"""

import ast
import hashlib
import importlib.metadata
import importlib.util
import sys
from functools import cache

OURS = ("hlcs", "minibullet")


@cache
def code_hash(root="hlcs.placement.single_run"):
    """Hash of the import closure of module `root`, 16 hexadecimal digits.

    Source text counts as Python reads it: the same with the line ends of Windows. Comments count too: too much is computed
    again rather than too little.
    """
    modules, libraries = closure(root)
    digest = hashlib.sha256()
    for name in modules:
        digest.update(f"{name} {hashlib.sha256(_source(name).encode()).hexdigest()}\n".encode())
    for name in libraries:
        digest.update(f"{name} {_version(name)}\n".encode())
    return digest.hexdigest()[:16]


def closure(root):
    """(own modules, libraries) that importing `root` needs, sorted names.

    A package's ``__init__`` counts where something is taken from it (``import minibullet as mb``), not where it is only
    passed on the way to a module in it.
    """
    found, libraries, waiting = set(), set(), [root]
    while waiting:
        name = waiting.pop()
        if name.partition(".")[0] not in OURS:
            libraries.add(name.partition(".")[0])
        elif name not in found:
            found.add(name)
            waiting += _imports(name)
    return sorted(found), sorted(libraries - sys.stdlib_module_names)


def _imports(name):
    """Names of the modules that module `name` imports when it is itself imported."""
    spec = importlib.util.find_spec(name)
    for node in _top(ast.parse(_source(name))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
            continue
        base = importlib.util.resolve_name("." * node.level + (node.module or ""), spec.parent) if node.level else node.module
        for alias in node.names:
            inside = f"{base}.{alias.name}"
            yield inside if base.partition(".")[0] in OURS and alias.name != "*" and _is_module(inside) else base


def _top(node):
    """The import statements under `node` that run when the module is imported."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield child
        elif not isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            yield from _top(child)


def _is_module(name):
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:  # what stands before the last dot is no package
        return False


def _source(name):
    """The text of a module, with line ends as Python reads them."""
    return importlib.util.find_spec(name).loader.get_source(name)


def _version(name):
    """The version of a library by the name it is imported under."""
    try:
        return importlib.import_module(name).__version__
    except AttributeError:  # it does not say itself; looking all packages through takes half a second
        return [importlib.metadata.version(package) for package in importlib.metadata.packages_distributions()[name]]

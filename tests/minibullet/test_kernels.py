"""Compiled code is kept for later runs, and never outlives the code that it was made of."""

import gc
import os
import shutil
import subprocess
import sys
from pathlib import Path

from numba.core import types
from numba.core.registry import CPUDispatcher

import minibullet
import minibullet as mb

KERNELS = Path(minibullet.__file__).parent / "kernels.py"


def test_a_kernel_is_compiled_again_when_a_function_that_it_calls_changes_in_another_file(tmp_path):
    """Numba alone looks at the kernel's own file only: it would go on with the old function inside."""
    package = tmp_path / "minibullet"
    package.mkdir()
    (package / "__init__.py").touch()
    shutil.copy(KERNELS, package)
    (package / "outer.py").write_text(
        "from minibullet.inner import add\nfrom minibullet.kernels import kernel\n\n\n"
        "@kernel\ndef double(x):\n    return 2.0 * add(x)\n"
    )
    environment = {key: value for key, value in os.environ.items() if not key.startswith("NUMBA")}
    for added, answer in ((1, "4.0"), (2, "6.0"), (1, "4.0")):
        (package / "inner.py").write_text(
            f"from minibullet.kernels import leaf\n\n\n@leaf\ndef add(x):\n    return x + {added}.0\n"
        )
        program = "from minibullet.outer import double; print(double(1.0), sum(double.stats.cache_hits.values()))"
        done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.stdout.split()[0] == answer, done.stderr
    assert done.stdout.split()[1] == "1"  # the third run found what the first one had kept
    assert len(list(package.glob("__pycache__/kernels-*"))) == 2


def test_no_compiled_function_returns_a_record_inside_another():
    """To hand one to Python Numba calls Python for its class: Ctrl-C in that call crashes the interpreter where another record
    is to be made around it."""
    world = mb.World(effects=[mb.Gravity(9.81)], settings=mb.Settings(solver="gauss_seidel"))
    world.add_plane()
    for k in range(3):
        world.add(mb.Box(0.1, 0.1, 0.1), density=1000, position=(0.09 * k, 0, 0.06 + 0.11 * k))
        world.add(mb.Sphere(0.05), density=1000, position=(0.09 * k, 0.3, 0.06 + 0.11 * k))
    world.step(30)
    records, answers = (types.NamedTuple, types.NamedUniTuple), []
    for one in gc.get_objects():  # isinstance would ask a weak proxy, whose object may be gone
        if issubclass(type(one), CPUDispatcher) and one.__module__.startswith("minibullet"):
            answers += [(one.__name__, overload.signature.return_type) for overload in one.overloads.values()]
    inner = {
        name for name, answer in answers if isinstance(answer, types.BaseTuple) for part in answer if isinstance(part, records)
    }
    assert any(isinstance(answer, records) for _, answer in answers) and not inner

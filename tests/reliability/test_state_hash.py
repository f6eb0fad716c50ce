"""The same bits: small scenes have the hashes of hashes.txt on every x86-64 Linux machine, whatever its processor can do.

Another processor is simulated in a process of its own: kernels compiled for a plain x86-64, one thread, the oldest kernels of the
linear algebra library, NumPy and the C library without their vector units. The continuous integration runs this file in a second
environment with the lowest supported dependencies too.
"""

import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from .lowest import lowest

ROOT = Path(__file__).resolve().parents[2]
HASHES = Path(__file__).with_name("hashes.txt")
core = getattr(np, "_core", None) or np.core  # the name before NumPy 2
PLAIN = {
    "NUMBA_CPU_NAME": "generic",
    "NUMBA_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_CORETYPE": "Prescott",
    "NPY_DISABLE_CPU_FEATURES": " ".join(core._multiarray_umath.__cpu_dispatch__),
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2",
}
PROCESSORS = {"this processor": {}, "a plain processor": PLAIN}
HERE = (platform.machine(), sys.platform) == ("x86_64", "linux")
pytestmark = pytest.mark.skipif(not HERE, reason="bits are promised on x86-64 Linux, see docs/reliability.md")


def elsewhere(*arguments, **environment):
    """Standard output of Python with these arguments in a process of its own."""
    finished = subprocess.run([sys.executable, "-W", "ignore", *arguments], cwd=ROOT, capture_output=True, text=True,
                              env={**os.environ, **environment}, timeout=600)  # fmt: skip
    assert finished.returncode == 0, finished.stdout + finished.stderr
    return finished.stdout


@pytest.mark.parametrize("processor", PROCESSORS)
def test_every_scene_has_its_hash_on(processor):
    """All solvers, all shapes, free flight, placement tests: every bit, as written down."""
    assert elsewhere("-m", "tests.reliability.state_hash", **PROCESSORS[processor]) == HASHES.read_text(encoding="utf-8")


def test_newtons_method_repeats_its_bits_and_differs_elsewhere_by_rounding_alone():
    """Steps beyond Gauss-Seidel factor a matrix by SciPy's library, whose last bits depend on the processor: two processes agree
    in every bit, a plain processor to 1e-9 m, m/s after half a second of a heap; the solver's own tolerance is 1e-8."""
    script = "from tests.reliability.state_hash import newton, state; print(*(x.hex() for x in state(newton()).ravel().tolist()))"
    first, again, plain = elsewhere("-c", script), elsewhere("-c", script), elsewhere("-c", script, **PLAIN)
    assert first == again
    numbers = [np.array([float.fromhex(x) for x in text.split()]) for text in (first, plain)]
    assert len(numbers[0]) == 12 * 13
    np.testing.assert_allclose(*numbers, rtol=0.0, atol=1e-9)


def test_a_diagnosis_repeats_its_bytes_and_its_verdict_elsewhere(tmp_path):
    """`diagnose --json` on a mystery: two processes write the same bytes; on a plain processor the same verdict and effects, and
    numbers equal to 1e-6 of themselves: the interval of the number found is two thousandths of it wide."""
    from hlcs import mystery

    experiment = mystery.copy(mystery.names()[0], tmp_path)
    texts = []
    for number, environment in enumerate(({}, {"PYTHONHASHSEED": "7"}, PLAIN)):
        elsewhere("-m", "hlcs", "diagnose", str(experiment), "--quiet", "--json", str(tmp_path / f"{number}.json"), **environment)
        texts.append((tmp_path / f"{number}.json").read_bytes())
    assert texts[0] == texts[1]
    here, plain = json.loads(texts[0]), json.loads(texts[2])
    assert (here["verdict"], here["effects"], here["ambiguous"]) == (plain["verdict"], plain["effects"], plain["ambiguous"])
    assert here["effects"]
    for effect, numbers in here["parameters"].items():
        for name, number in numbers.items():
            for key in ("value", "low", "high"):
                assert plain["parameters"][effect][name][key] == pytest.approx(number[key], rel=1e-6)


def test_the_second_environment_holds_exactly_the_floors():
    """Every requirement that has a floor becomes that version, exactly; none is lost."""
    found = lowest("test")
    assert "numpy==1.26" in " ".join(found) and not any(">=" in one for one in found)
    assert len(found) == len(set(found)) and all("==" in one for one in found)

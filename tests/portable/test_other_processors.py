import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest
from processors import OTHERS

TOP = Path(__file__).resolve().parents[2]
EXAMPLE = TOP / "sessions" / "example"

pytestmark = pytest.mark.skipif(
    platform.machine() != "x86_64", reason="instructions are left out of x86-64 ones"
)


def run(*words, other=None) -> subprocess.CompletedProcess:
    environment = os.environ | {"PYTHONPATH": str(TOP)} | (OTHERS[other] if other else {})
    return subprocess.run(
        [sys.executable, *map(str, words)], env=environment, capture_output=True, text=True
    )


def replayed(folder, other=None) -> list[str]:
    """What the replay says of each task, when it finds no other result."""
    said = run("-m", "workbench", "session", "replay", folder, other=other)
    assert said.returncode == 0, said.stdout + said.stderr
    return [line.partition(": ")[2] for line in said.stdout.splitlines()[:-1]]


@pytest.mark.parametrize("other", OTHERS)
def test_the_example_comes_out_the_same_on_another_processor(other):
    says = replayed(EXAMPLE, other)
    assert len(says) == 3 and all(one.startswith(("equal", "the same within")) for one in says)


@pytest.fixture(scope="module")
def recorded_elsewhere(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("sessions") / "elsewhere"
    made = run(TOP / "sessions" / "make_example.py", folder, other="plain instructions everywhere")
    assert made.returncode == 0, made.stdout + made.stderr
    return folder


def test_a_session_recorded_on_another_processor_comes_out_the_same_here(recorded_elsewhere):
    says = replayed(recorded_elsewhere)
    assert len(says) == 3 and all(one.startswith(("equal", "the same within")) for one in says)


KERNEL = """
import ctypes, glob, os, {first}
import numpy
folder = os.path.dirname(numpy.__file__) + ".libs"
(library,) = glob.glob(folder + "/libscipy_openblas*")
name = ctypes.CDLL(library).scipy_openblas_get_corename64_
name.restype = ctypes.c_char_p
features = numpy._core._multiarray_umath.__cpu_features__
print(name().decode(), any(features.get(one) for one in ("X86_V4", "AVX512_ICL", "AVX512_SPR")))
"""


def test_linear_algebra_and_vectors_are_those_that_every_processor_has():
    clean = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("OPENBLAS_", "NPY_"))
    }
    said = subprocess.run(
        [sys.executable, "-c", KERNEL.format(first="workbench")],
        env=clean | {"PYTHONPATH": str(TOP)},
        capture_output=True,
        text=True,
    )
    assert said.stdout.split() == ["Nehalem", "False"], said.stdout + said.stderr

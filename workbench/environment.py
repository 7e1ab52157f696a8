"""What libraries look at when they are loaded: which instructions they use, where they keep code.

It has to be set before any of them is imported, so the package itself does it.  What somebody has
set already stands.
"""

import atexit
import os
import platform
import shutil
import tempfile
from pathlib import Path

V3 = frozenset(["abm", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"])
"""What x86-64-v3 adds, in Linux's words: every processor with AVX2 has it."""


def prepare() -> None:
    """Set it, for this process and those that it starts."""
    _take_common_instructions()
    # TBB comes last: where an old one is installed, numba warns of it at every start.
    os.environ.setdefault("NUMBA_THREADING_LAYER_PRIORITY", "omp tbb workqueue")
    _keep_compiled_code()


def _take_common_instructions() -> None:
    """Have results be the same on every x86-64 processor with AVX2.

    NumPy and its linear algebra choose their instructions by the make of processor, and these
    round differently: enough to find a part turned by a symmetry of its.  Matrices are small here,
    so one thread and plain instructions cost no time.  numba compiles for the same processors, so
    what one machine has compiled serves the others.
    """
    if platform.machine() in ("x86_64", "AMD64"):
        os.environ.setdefault("OPENBLAS_CORETYPE", "Nehalem")
        os.environ.setdefault("NPY_DISABLE_CPU_FEATURES", "X86_V4 AVX512_ICL AVX512_SPR")
        if "NUMBA_CPU_NAME" not in os.environ and _instructions() >= V3:
            os.environ.update(NUMBA_CPU_NAME="x86-64-v3", NUMBA_CPU_FEATURES="")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def _instructions() -> set[str]:
    """What Linux says the processor can; nothing elsewhere."""
    try:
        with open("/proc/cpuinfo") as cpuinfo:
            return next(set(line.split()) for line in cpuinfo if line.startswith("flags"))
    except (OSError, StopIteration):
        return set()


def _keep_compiled_code() -> None:
    """Name a folder for compiled code where it cannot lie beside the sources.

    That is so where somebody else has installed them.  The folder is the user's own, since what
    lies in it is run.  Where there is none either, code is kept for as long as this process runs
    and those that it starts.
    """
    if os.environ.get("NUMBA_CACHE_DIR") or _is_writable(Path(__file__).parent / "__pycache__"):
        return
    own = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
    kept = own / "workbench" / "compiled"
    if not _is_writable(kept):
        kept = Path(tempfile.mkdtemp(prefix="workbench-compiled-"))
        atexit.register(shutil.rmtree, kept, ignore_errors=True)
    os.environ["NUMBA_CACHE_DIR"] = str(kept)


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True

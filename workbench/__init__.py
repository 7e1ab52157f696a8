"""Workbench: plan, prove, approve and run robotic bin picks from a web page."""

import atexit
import os
import shutil
import tempfile
from pathlib import Path

__version__ = "0.1.0"


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


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


# Numba reads it when it is imported, which everything below this package may do.
_keep_compiled_code()

"""Compiles nothing, as the program that compiles would; for the tests of readiness."""

import os
import sys
import time
from pathlib import Path

from workbench.app.runtime.compiled_code import is_ready, mark_ready, only_one
from workbench.app.runtime.readiness import end_with_input

use = sys.argv[1]
folder = Path(os.environ["TINY_FOLDER"])
end_with_input()
if (folder / "broken").exists():
    raise ValueError("no compiler")
with only_one(use):
    if not is_ready(use):
        (folder / f"{use}-{os.getpid()}").touch()
        print("a library says something", flush=True)
        print(0.5, flush=True)
        if (folder / "garbled").exists():
            os.write(1, b"\xff\n")
        while (folder / "hold").exists():
            time.sleep(0.01)
        mark_ready(use)

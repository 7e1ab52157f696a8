"""Libraries that the page needs sooner or later, loaded while it starts.

While a library is loaded no other thread of the process runs, for up to a second; and so it is,
for a tenth of a second, whenever Python looks for garbage among all that the libraries have made.
At the start nothing moves yet.
"""

import gc
import importlib
import logging
import threading

log = logging.getLogger(__name__)

LATER = (
    "workbench.perception.scene.unexplained",
    "workbench.app.calibration.held_plate",
    "workbench.app.calibration.next_pose",
    "workbench.app.review.scanner_drift",
)
"""Modules that are imported where they are needed, since a start does not wait for them."""


def load_ahead() -> threading.Thread:
    """Load them in a thread, which ends when all is there."""
    thread = threading.Thread(target=_load, name="loading", daemon=True)
    thread.start()
    return thread


def _load() -> None:
    gc.disable()
    try:
        for module in LATER:
            importlib.import_module(module)
    except Exception:
        # A rim: what is missing is told where it is needed.
        log.exception("a library could not be loaded ahead")
    finally:
        # What is there now stays for good: nobody needs to look for garbage among it again.
        gc.freeze()
        gc.enable()

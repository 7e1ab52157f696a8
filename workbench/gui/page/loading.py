"""Libraries that the page needs sooner or later, loaded while it starts.

While a library is loaded no other thread of the process runs, for up to a second; and so it is,
for a tenth of a second, whenever Python looks for garbage among all that the libraries have made.
At the start nothing moves yet.
"""

import gc
import importlib
import logging
import threading
from collections.abc import Generator
from contextlib import contextmanager

log = logging.getLogger(__name__)

LATER = (
    "workbench.perception.scene.unexplained",
    "workbench.app.calibration.ball_plate",
    "workbench.app.calibration.next_pose",
    "workbench.app.review.scanner_drift",
)
"""Modules that are imported where they are needed, since a start does not wait for them."""


@contextmanager
def loaded_ahead() -> Generator[None]:
    """Load them in a thread while the block runs; its end waits for the module at hand.

    A process that ends while Open3D is being loaded ends with the exit code 1.
    """
    is_over = threading.Event()
    thread = threading.Thread(target=_load, args=(is_over,), name="loading", daemon=True)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()


def _load(is_over: threading.Event) -> None:
    gc.disable()
    try:
        for module in LATER:
            if not is_over.is_set():
                importlib.import_module(module)
    except Exception:
        # A rim: what is missing is told where it is needed.
        log.exception("a library could not be loaded ahead")
    finally:
        # What is there now stays for good: nobody needs to look for garbage among it again.
        gc.freeze()
        gc.enable()

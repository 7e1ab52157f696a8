"""Libraries and compiled code loaded without looking for garbage among what stays."""

import gc
from collections.abc import Generator
from contextlib import contextmanager


@contextmanager
def loading() -> Generator[None]:
    """No garbage is searched for while the block runs, and never in what it has loaded.

    What is loaded stays until the process ends.  It comes in such numbers that Python looks
    through all of it again and again, which takes a tenth of a command's start.
    """
    was_looking = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_looking:
            gc.freeze()
            gc.enable()

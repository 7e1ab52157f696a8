"""Whether what numba compiles is ready on this machine, and the one way to make it so.

The inner loops of seeing and planning are compiled at their first use, which takes about a
minute, and kept on disk.  Here that is a stage of its own: processes compile, each its share,
and tell how far they are; whoever waits loads afterwards what they have kept.
"""

import contextlib
import logging
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Generator, Sequence
from queue import SimpleQueue
from typing import IO

from workbench.app.runtime.compiled_code import (
    USES,
    Use,
    forget_the_old,
    is_ready,
    take_shipped,
)
from workbench.model.messages.work import ProgressText
from workbench.plugins.progress import Report

log = logging.getLogger(__name__)

NOTE = ProgressText.GETTING_READY()
"""What is shown meanwhile."""

WARM_UP = "workbench.app.runtime.warm_up"
"""The program that compiles for one use."""


def make_ready(report: Report, uses: Sequence[Use] = USES) -> bool:
    """Compile what is not ready; returns at once when everything is.

    Several may be at it at the same time: one compiles, the others wait for it.  The processes end
    with this one.

    Args:
        report: called now and then, with `NOTE`; not at all when nothing is to be done.
        uses: what is wanted.

    Returns:
        Whether all is ready.  What is not is compiled at its first use instead; why is logged.
    """
    if all(map(is_ready, uses)):
        return True
    forget_the_old()
    take_shipped()
    missing: list[Use] = [use for use in uses if not is_ready(use)]
    if not missing:
        return True
    report(0.0, NOTE)
    news: SimpleQueue[tuple[Use, float | None]] = SimpleQueue()
    shares: dict[Use, float] = dict.fromkeys(missing, 0.0)
    running = set(missing)
    try:
        with contextlib.ExitStack() as stack:
            for use in missing:
                stack.enter_context(_compiling(use, news))
            while running:
                use, share = news.get()
                shares[use] = 1.0 if share is None else share
                if share is None:
                    running.remove(use)
                report(sum(shares.values()) / len(shares), NOTE)
    except OSError as error:
        log.warning("what is used first could not be compiled ahead: %s", error)
    return all(is_ready(use) for use in missing)


def end_with_input() -> None:
    """From now on this process ends when nobody holds the other end of its standard input."""

    def wait() -> None:
        # Not through the buffer, whose lock the end of the interpreter wants.
        os.read(0, 1)
        os._exit(1)

    threading.Thread(target=wait, name="end with input", daemon=True).start()


@contextlib.contextmanager
def _compiling(use: Use, news: SimpleQueue[tuple[Use, float | None]]) -> Generator[None]:
    """A process that compiles while the block runs; `news` its shares done, None at its end."""
    with (
        tempfile.TemporaryFile() as errors,
        subprocess.Popen(
            [sys.executable, "-m", WARM_UP, use],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
            errors="replace",
        ) as process,
    ):
        listener = threading.Thread(target=_listen, args=(process.stdout, use, news), daemon=True)
        listener.start()
        try:
            yield
        except BaseException:
            process.kill()
            raise
        finally:
            listener.join()
        if process.wait() != 0:
            errors.seek(0)
            said = errors.read().decode(errors="replace").strip().splitlines()
            why = said[-1] if said else f"exit code {process.returncode}"
            log.warning("what %s needs could not be compiled ahead: %s", use, why)


def _listen(output: IO[str] | None, use: Use, news: SimpleQueue[tuple[Use, float | None]]) -> None:
    try:
        for line in output or ():
            # A library may say something too.
            with contextlib.suppress(ValueError):
                news.put((use, min(max(float(line), 0.0), 1.0)))
    finally:
        # Somebody waits for the end, however it comes.
        news.put((use, None))

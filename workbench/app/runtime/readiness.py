"""Whether what numba compiles is ready on this machine, and the one way to make it so.

The inner loops of seeing and planning are compiled at their first use, which takes about a
minute, and kept on disk.  Here that is a stage of its own: processes compile, each its share,
and tell how far they are; whoever waits loads afterwards what they have kept.
"""

import contextlib
import fcntl
import hashlib
import importlib.metadata
import logging
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from pathlib import Path
from queue import SimpleQueue
from typing import IO, Literal

import llvmlite.binding as llvm
from numba.core import caching, config

import workbench

log = logging.getLogger(__name__)

Use = Literal["seeing", "planning"]
USES: tuple[Use, ...] = ("seeing", "planning")
"""What can be made ready by itself; planning includes grasps."""

NOTE = "getting ready, once, about a minute"
"""What is told meanwhile."""

LAYERS = ("formats", "perception", "planning", "proof")
"""Whose functions are compiled."""

WARM_UP = "workbench.app.runtime.warm_up"
"""The program that compiles for one use."""

Report = Callable[[float, str], None]
"""Called with the share done, 0..1, and what is being done."""


def is_ready(use: Use) -> bool:
    """Whether these sources were once compiled for that use, by this numba for this processor."""
    if getattr(config, "DISABLE_JIT", 0):
        return True
    try:
        return _stamp(use).read_text() == _fingerprint()
    except OSError:
        return False


def make_ready(report: Report, uses: Sequence[Use] = USES) -> bool:
    """Compile what is not ready; returns at once when everything is.

    Several may be at it at the same time: one compiles, the others wait for it.  The processes end
    with this one.

    Args:
        report: told now and then, with `NOTE`; not at all when nothing is to be done.
        uses: what is wanted.

    Returns:
        Whether all is ready.  What is not is compiled at its first use instead; why is logged.
    """
    missing: list[Use] = [use for use in uses if not is_ready(use)]
    if not missing:
        return True
    report(0.0, NOTE)
    told: SimpleQueue[tuple[Use, float | None]] = SimpleQueue()
    shares: dict[Use, float] = dict.fromkeys(missing, 0.0)
    running = set(missing)
    try:
        _forget_the_old()
        with contextlib.ExitStack() as stack:
            for use in missing:
                stack.enter_context(_compiling(use, told))
            while running:
                use, share = told.get()
                shares[use] = 1.0 if share is None else share
                if share is None:
                    running.remove(use)
                report(sum(shares.values()) / len(shares), NOTE)
    except OSError as error:
        log.warning("what is used first could not be compiled ahead: %s", error)
    return all(is_ready(use) for use in missing)


def mark_ready(use: Use) -> None:
    """Remember that it was compiled."""
    _stamp(use).write_text(_fingerprint())


@contextlib.contextmanager
def only_one(use: Use) -> Generator[None]:
    """Wait until no other process compiles for that use, and keep others from it.

    numba's own files are not safe from two that write them: one might load what the other has
    compiled for other types.  The system lets go of the lock when its holder ends, however.
    """
    place = _stamp(use).with_suffix(".lock")
    place.parent.mkdir(parents=True, exist_ok=True)
    with place.open("a") as held:
        # Some network file systems know no locks.
        with contextlib.suppress(OSError):
            fcntl.flock(held, fcntl.LOCK_EX)
        yield


def end_with_input() -> None:
    """From now on this process ends when nobody holds the other end of its standard input."""

    def wait() -> None:
        # Not through the buffer, whose lock the end of the interpreter wants.
        os.read(0, 1)
        os._exit(1)

    threading.Thread(target=wait, name="end with input", daemon=True).start()


def _forget_the_old() -> None:
    """Delete what was compiled from other sources, if nothing is ready yet.

    numba looks at the file that a function stands in, not at those of the functions that were
    compiled into it: after an update some would go on as before.
    """
    with only_one("seeing"), only_one("planning"):
        if not any(is_ready(use) for use in USES):
            for place in _kept():
                for file in place.glob("*.nb[ic]"):
                    file.unlink(missing_ok=True)


def _kept() -> Iterator[Path]:
    """Where numba keeps what it compiles of these sources."""
    kept = os.environ.get("NUMBA_CACHE_DIR")
    for folder in sorted({file.parent for file in _sources()}):
        if kept is None:
            yield folder / "__pycache__"
        else:
            under = caching._CacheLocator.get_suitable_cache_subpath(str(folder / "any.py"))  # pyright: ignore
            yield Path(kept) / under


@contextlib.contextmanager
def _compiling(use: Use, told: SimpleQueue[tuple[Use, float | None]]) -> Generator[None]:
    """A process that compiles while the block runs; `told` its shares done, None at its end."""
    with (
        tempfile.TemporaryFile() as errors,
        subprocess.Popen(
            [sys.executable, "-m", WARM_UP, use],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
        ) as process,
    ):
        listener = threading.Thread(target=_listen, args=(process.stdout, use, told), daemon=True)
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


def _listen(output: IO[str] | None, use: Use, told: SimpleQueue[tuple[Use, float | None]]) -> None:
    for line in output or ():
        # A library may say something too.
        with contextlib.suppress(ValueError):
            told.put((use, min(max(float(line), 0.0), 1.0)))
    told.put((use, None))


def _package() -> Path:
    return Path(workbench.__file__).parent


def _stamp(use: Use) -> Path:
    package, kept = _package(), os.environ.get("NUMBA_CACHE_DIR")
    name = hashlib.sha256(os.fsencode(package)).hexdigest()[:12]
    return (Path(kept) if kept else package / "__pycache__") / f"workbench-{name}-{use}.ready"


def _sources() -> list[Path]:
    package = _package()
    return sorted(file for layer in LAYERS for file in (package / layer).rglob("*.py"))


def _fingerprint() -> str:
    """Of all that compiled code depends on."""
    stats = [(file.name, status.st_size, status.st_mtime_ns) for file in _sources()
             for status in [file.stat()]]  # fmt: skip
    processor = (llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten())
    version = (sys.version, importlib.metadata.version("numba"))
    return hashlib.sha256(repr((stats, processor, version)).encode()).hexdigest()

"""What numba has compiled of these sources: where it lies, and whether it is still good.

A wheel holds what was compiled where it was built: on a machine of that kind nobody waits.
"""

import contextlib
import fcntl
import hashlib
import importlib.metadata
import logging
import os
import re
import shutil
import sys
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Literal

import llvmlite.binding as llvm
from numba.core import caching, config

import workbench

log = logging.getLogger(__name__)

Use = Literal["seeing", "planning"]
USES: tuple[Use, ...] = ("seeing", "planning")
"""What can be made ready by itself; planning includes grasps."""

LAYERS = ("formats", "perception", "planning", "proof")
"""Whose functions are compiled."""

IMPORTED = re.compile(r"^from workbench\.([\w.]+) import ", re.MULTILINE)
"""A module that another one imports from."""


def is_ready(use: Use) -> bool:
    """Whether these sources were once compiled for that use, by this numba for this processor."""
    if getattr(config, "DISABLE_JIT", 0):
        return True
    return _is_of_these_sources(_stamp(use))


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


def forget_the_old() -> None:
    """Delete what was compiled from other sources; costs next to nothing where there is none.

    numba looks at the file that a function stands in, not at those of the functions that were
    compiled into it: after an update some would go on as before, and others would not load.
    """
    if any(map(is_ready, USES)) or _is_of_these_sources(_origin()):
        return
    # Nobody can write where nothing is kept, either.
    with contextlib.suppress(OSError), only_one("seeing"), only_one("planning"):
        if not any(map(is_ready, USES)) and not _is_of_these_sources(_origin()):
            for place in _find_caches():
                for file in place.glob("*.nb[ic]"):
                    file.unlink(missing_ok=True)
            _origin().write_text(_fingerprint())


def take_shipped() -> None:
    """Copy what was compiled beside the sources to where code is kept, if that is another place.

    So it is where a package is installed that its user cannot write to.
    """
    kept = os.environ.get("NUMBA_CACHE_DIR")
    if kept is None or not all(_is_of_these_sources(_shipped_stamp(use)) for use in USES):
        return
    try:
        with only_one("seeing"), only_one("planning"):
            if not any(is_ready(use) for use in USES):
                for folder, place in _places(kept):
                    place.mkdir(parents=True, exist_ok=True)
                    for file in (folder / "__pycache__").glob("*.nb[ic]"):
                        shutil.copyfile(file, place / file.name)
                for use in USES:
                    mark_ready(use)
    except OSError as error:
        log.warning("what was compiled before could not be copied: %s", error)


def _find_caches() -> Iterator[Path]:
    """Where numba keeps what it compiles of these sources."""
    kept = os.environ.get("NUMBA_CACHE_DIR")
    if kept is None:
        yield from (folder / "__pycache__" for folder in _folders())
    else:
        yield from (place for _, place in _places(kept))


def _places(kept: str) -> Iterator[tuple[Path, Path]]:
    """Folders of sources, each with that in which numba keeps their code in a place of its own."""
    for folder in _folders():
        under = caching._CacheLocator.get_suitable_cache_subpath(str(folder / "any.py"))  # pyright: ignore
        yield folder, Path(kept) / under


def _folders() -> list[Path]:
    return sorted({file.parent for file in _list_sources()})


def _package() -> Path:
    return Path(workbench.__file__).parent


def _stamp(use: Use) -> Path:
    kept = os.environ.get("NUMBA_CACHE_DIR")
    if kept is None:
        return _shipped_stamp(use)
    name = hashlib.sha256(os.fsencode(_package())).hexdigest()[:12]
    return Path(kept) / f"workbench-{name}-{use}.ready"


def _origin() -> Path:
    """The file that says of which sources all code is that is kept, ready or not."""
    return _stamp("planning").with_suffix(".origin")


def _shipped_stamp(use: Use) -> Path:
    return _package() / "__pycache__" / f"{use}.ready"


def _is_of_these_sources(stamp: Path) -> bool:
    try:
        return stamp.read_text() == _fingerprint()
    except OSError:
        return False


def _list_sources() -> Iterator[Path]:
    """The files of the functions that are compiled."""
    package = _package()
    for layer in LAYERS:
        for file in sorted((package / layer).rglob("*.py")):
            if b"njit" in file.read_bytes():
                yield file


def _sources() -> set[Path]:
    """The same, and what they import: constants are compiled into code."""
    package, files = _package(), set(_list_sources())
    for file in tuple(files):
        for module in IMPORTED.findall(file.read_text()):
            files.add(package.joinpath(*module.split(".")).with_suffix(".py"))
    return files


def _fingerprint() -> str:
    """Of all that compiled code depends on, the same wherever that is the same."""
    package = _package()
    sources = {
        file.relative_to(package).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in _sources()
        if file.is_file()
    }
    name, features = getattr(config, "CPU_NAME", None), getattr(config, "CPU_FEATURES", None)
    if features is None:
        features = llvm.get_host_cpu_features().flatten()
    processor = (llvm.get_process_triple(), name or llvm.get_host_cpu_name(), features)
    version = (sys.implementation.cache_tag, importlib.metadata.version("numba"))
    return hashlib.sha256(repr((sorted(sources.items()), processor, version)).encode()).hexdigest()

"""The cell file watched: when somebody has written it, the session goes on with what it says."""

import logging
import threading
from pathlib import Path

from workbench.app.core.cell.changes import CellRead
from workbench.app.core.people import CELL_FILE
from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import part_folders, read_cell
from workbench.formats.parts.saves import DRAFT, VERSIONS
from workbench.model.errors import CommandRefused, InputError

log = logging.getLogger(__name__)

POLL_EVERY = 0.5
"""[s] Between two looks at the files."""

FILE_ENDINGS = frozenset(
    {".toml", ".urdf", ".srdf", ".stl", ".obj", ".ply", ".glb", ".dae", ".pcd"},
)
"""Endings of the files that a cell is read from: tables, robots, meshes."""

Stamp = tuple[tuple[str, int, int], ...]
"""Names, times and sizes of the files."""


class CellWatch:
    """Reads the cell again when a file in its folder has changed and is left alone since.

    Lifetime: from construction until `close`, which waits for a reading under way.

    Concurrency: a thread of its own, which gives `CellRead` commands.
    """

    def __init__(self, path: Path, bench: Bench, *, every: float = POLL_EVERY) -> None:
        """Begin to watch.

        Args:
            path: of the cell file that the bench has begun with.
            bench: gets the cell that is read.
            every: how long [s] between two looks.
        """
        self._path = path
        self._bench = bench
        self._every = every
        self._closing = threading.Event()
        # The files are read once in any case: since the bench has read them they may have changed.
        self._read: Stamp = ()
        self._thread = threading.Thread(target=self._run, name="cell file", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Look no more."""
        self._closing.set()
        self._thread.join()

    def _run(self) -> None:
        seen = self._read
        while not self._closing.wait(self._every):
            try:
                now = self._stamp()
                # A file that still changes is not read: editors write in several steps.
                if now != self._read and now == seen and self._take():
                    self._read = now
                seen = now
            except Exception:
                log.exception("the cell file could not be looked at")

    def _stamp(self) -> Stamp:
        found: list[tuple[str, int, int]] = []
        files = [file for folder in self._folders() for file in sorted(folder.rglob("*"))]
        for file in files:
            if (
                file.suffix.lower() in FILE_ENDINGS
                and not file.name.startswith(".")
                and not _is_kept(file)
            ):
                try:
                    status = file.stat()
                except OSError:
                    continue  # gone in between: the next look tells
                found.append((str(file), status.st_mtime_ns, status.st_size))
        return tuple(found)

    def _folders(self) -> list[Path]:
        """Where the files lie: beside the cell file, and those of its parts."""
        try:
            parts = part_folders(self._path).values()
        except InputError:
            parts = ()  # the file is broken: what it names is looked for when it is whole again
        return [self._path.parent, *parts]

    def _take(self) -> bool:
        """Read the cell and hand it over; whether it was taken."""
        state = self._bench.state
        if self._bench.live.is_saving and not state.is_saved:
            return False  # the file may hold half of what is to be saved: that is not given up
        try:
            cell = read_cell(self._path)
            is_known = cell.digest == state.saved and cell.approvers == state.cell.approvers
            if is_known and not state.cell_problem:
                return True
            command = CellRead(cell)
        except InputError as error:
            command = CellRead(problem=str(error))
        try:
            self._bench.do(command, CELL_FILE)
        except CommandRefused as error:
            log.info("the cell file is read later: %s", error)
            return False
        return True


def _is_kept(file: Path) -> bool:
    """Whether a file is a draft or an older version, which a cell does not hold."""
    return file.name == DRAFT or file.parent.name == VERSIONS

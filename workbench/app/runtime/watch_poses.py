"""The watched folder of another program: poses of parts that it puts there are taken."""

import logging
import threading
import time
from pathlib import Path

from workbench.app.core.command import Command
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.people import POSES_FOLDER
from workbench.app.core.session import PosesRefused
from workbench.app.core.state import State
from workbench.app.core.value_checks import LONGEST_NAME
from workbench.app.runtime.bench import Bench
from workbench.formats.files.whole_files import Stamp, stamps
from workbench.formats.plans.pose_files import read_poses
from workbench.model.errors import CommandRefused, InputError
from workbench.model.messages.commands import EditText
from workbench.model.scan import PosesFolder

log = logging.getLogger(__name__)

POLL_EVERY = 0.1
"""[s] Between two looks into the folder."""

COMPLETE_AFTER = 0.3
"""[s] A file that has not changed for that long is complete."""

FILE_ENDINGS = frozenset({".txt", ".json", ".tuple", ".tup"})

LONGEST_PROBLEM = 300
"""Characters of a problem that are reported."""


class PosesWatch:
    """Takes poses from each file that is written into the folder, as if a person had given it.

    What lies there already when the watch begins is left alone: it may be of another bin.  A file
    counts when it has stopped growing or was renamed into place, and again when it is written
    again.  One that cannot be used is reported, and the next one is checked.

    Lifetime: from construction until `close`; a folder that is not there is waited for.

    Concurrency: a thread of its own, which gives commands.
    """

    def __init__(
        self, bench: Bench, *, every: float = POLL_EVERY, still: float = COMPLETE_AFTER
    ) -> None:
        """Begin to watch the folder that the bench's cell names, whichever that is by then.

        Args:
            bench: gets the poses.
            every: how long [s] between two looks.
            still: how long [s] a complete file has not changed.
        """
        self._bench = bench
        self._every, self._still = every, still
        self._closing = threading.Event()
        self._folder: PosesFolder | None = None
        self._done: dict[Path, Stamp] = {}
        self._seen: dict[Path, tuple[Stamp, float]] = {}
        self._look()
        self._thread = threading.Thread(target=self._run, name="poses folder", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Look no more."""
        self._closing.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._closing.wait(self._every):
            try:
                self._look()
            except Exception:
                log.exception("the folder of poses could not be looked at")

    def _look(self) -> None:
        folder = self._bench.state.cell.poses_folder
        if folder is None:
            self._folder = None
            return
        try:
            files, is_there = stamps(Path(folder.path), FILE_ENDINGS), True
        except OSError:  # it is not there yet, or not just now
            files, is_there = dict[Path, Stamp](), False
        if self._folder is None or folder.path != self._folder.path:
            self._done, self._seen = files, {}
        elif is_there:
            # Those that were taken away again are forgotten: a folder may see millions.
            self._done = {path: self._done[path] for path in files if path in self._done}
            self._seen = {path: self._seen[path] for path in files if path in self._seen}
        self._folder = folder
        now = time.monotonic()
        # The newest one last, so that what is older does not take its place.
        for path, stamp in sorted(files.items(), key=lambda file: file[1]):
            if self._done.get(path) == stamp:
                continue
            known, since = self._seen.get(path, (None, now))
            if known != stamp:
                self._seen[path] = (stamp, now)
            elif now - since >= self._still and self._take(path, folder):
                self._done[path] = stamp  # nothing is taken twice, whatever came of it
                del self._seen[path]

    def _take(self, path: Path, folder: PosesFolder) -> bool:
        """Read a file and hand its poses over; False where it has to wait until a task ends."""
        parts = self._bench.state.cell.parts
        command: Command
        try:
            detections = read_poses(path, folder.part or (parts[0].name if parts else ""))
            says = EditText.POSES_FROM(
                count=len(detections), file=_shorten(path.name, LONGEST_NAME)
            )
            command = UseDetections(detections, says)
        except InputError as error:
            command = PosesRefused(_shorten(str(error)))
        before = self._bench.state
        try:
            self._bench.do(command, POSES_FOLDER)
        except CommandRefused as error:
            if isinstance(command, UseDetections):
                return self._refuse(path, error, before)
            log.error("poses cannot be used: %s", error)
        return True

    def _refuse(self, path: Path, error: CommandRefused, before: State) -> bool:
        """Poses of parts that the cell does not know are reported; a busy bench is waited for."""
        # A task that has ended meanwhile was in the way all the same.
        if self._bench.state is not before or before.job is not None:
            return False
        try:
            self._bench.do(PosesRefused(_shorten(f"{path.name}: {error}")), POSES_FOLDER)
        except CommandRefused as second:
            log.error("poses cannot be used: %s", second)
        return True


def _shorten(text: str, longest: int = LONGEST_PROBLEM) -> str:
    """A text that can be recorded and shown, whatever the name of the file in it holds."""
    return "".join(letter if letter.isprintable() else "?" for letter in text[:longest])

"""What a running program takes of the machine: memory, open files, threads, its session on disk."""

import contextlib
import os
from dataclasses import dataclass
from pathlib import Path

MEGABYTE = 2**20


@dataclass(frozen=True, slots=True)
class Footprint:
    """At one moment (Linux): `own` is this process, `others` those that it has started.

    Attributes:
        own, others: resident memory [bytes].
        files: open file descriptors, sockets and pipes included, of all.
        threads: of all.
        journal: size of the session's journal, the files of its database together [bytes].
    """

    own: int
    others: int
    files: int
    threads: int
    journal: int


def footprint(session: Path) -> Footprint:
    """What is taken now; `session` is the folder of a session."""
    children: set[int] = set()
    for task in Path("/proc/self/task").iterdir():
        # A thread may have ended since it was listed.
        with contextlib.suppress(OSError):
            children.update(map(int, (task / "children").read_text().split()))
    everybody = (os.getpid(), *children)
    return Footprint(
        _resident(os.getpid()),
        sum(_resident(child) for child in children),
        sum(_count(process, "fd") for process in everybody),
        sum(_count(process, "task") for process in everybody),
        sum(file.stat().st_size for file in session.glob("journal*") if file.is_file()),
    )


def _resident(process: int) -> int:
    try:
        pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    except (OSError, IndexError):
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")


def _count(process: int, what: str) -> int:
    try:
        return len(os.listdir(f"/proc/{process}/{what}"))
    except OSError:
        return 0

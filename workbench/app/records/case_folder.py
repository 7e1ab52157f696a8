"""The cases of a session: who may keep one, what it is made of, and where it lies."""

import re
import threading
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal, get_args

from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.people import Role
from workbench.app.core.rights import lacks_right
from workbench.app.core.state import Phase, State
from workbench.app.core.value_checks import check_among, check_text
from workbench.app.records.cases import Case, write_case
from workbench.formats.files.whole_files import file_name, is_folder, make_folder
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, FileError
from workbench.model.messages.message import Message
from workbench.model.messages.work import CaseRefusal
from workbench.model.scan import SearchRecord

FOLDER = "cases"
"""In the folder of a session."""

CASE_NAME = re.compile(r"\d{8}-\d{6}-[A-Za-z0-9_.-]{1,60}-\d{1,9}\.zip", re.ASCII)
"""What a case is called: when it was kept, in which cell, and the entry that it is of."""

MOST_CASES = 100
"""In one session."""

There = Literal["listed", "listed alone", "nothing"]
"""What a person says lies in the scan: the parts that are listed, and whether there are others."""

_KEEPING = threading.Lock()


def keeping_problem(state: State, actor: str, role: Role) -> Message | None:
    """Why this person may not store what was found as a case now; None when they may.

    Whoever may correct what was found may keep it.
    """
    wanted = UseDetections.right.role
    if not role.covers(wanted):
        return CaseRefusal.OTHER_ROLE(role=wanted.several(), yours=role.said())
    if problem := lacks_right(state, UseDetections, actor, role):
        return problem
    # Packing a scan takes a second of the process that speaks with the robot.
    if state.phase is Phase.SENDING:
        return CaseRefusal.SENDING()
    if state.scan is None or not state.searches:
        return CaseRefusal.NOTHING_FOUND()
    return None


def keep_case(
    session: Path,
    state: State,
    comment: str,
    there: There,
    *,
    actor: str,
    role: Role,
    at: float,
) -> Path:
    """Keep what was found in the scan, with the parts as people have left them.

    Args:
        session: folder of the session; the case lies in a folder `cases` there.
        state: of the session.
        comment: what was wrong, in a line.
        there: what lies there: the parts of the state and perhaps others, these alone, or nothing.
        actor: who keeps it.
        role: of that person.
        at: seconds since the epoch.

    Returns:
        The file.

    Raises:
        CommandRefused: this person may not, there is nothing to keep, the comment is no line of
            text, or as many cases are kept as may be.
        FileError: it cannot be written.
    """
    if problem := keeping_problem(state, actor, role):
        raise CommandRefused(problem)
    check_text("comment", comment)
    check_among("there", there, get_args(There))
    assert state.scan is not None
    truth = () if there == "nothing" else state.detections or ()
    is_complete = there != "listed"
    case = Case(
        at, actor, comment, is_complete, state.cell, state.scan, _corrected_search(state), truth
    )
    when = datetime.fromtimestamp(at, UTC).strftime("%Y%m%d-%H%M%S")
    name = f"{when}-{file_name(state.cell.name)[:60]}-{state.number}.zip"
    folder = session / FOLDER
    with _KEEPING:
        kept = case_files(session)
        if folder / name in kept:
            raise CommandRefused(CaseRefusal.STORED(name=name))
        if len(kept) >= MOST_CASES:
            raise CommandRefused(CaseRefusal.MOST(most=MOST_CASES, folder=str(folder)))
        make_folder(folder)
        write_case(folder / name, case)
    return folder / name


def _corrected_search(state: State) -> SearchRecord:
    """The search that people have corrected: others may have been made only to be compared."""
    first = state.parts_before[-1] if state.parts_before else state.detections or ()
    wanted = digest_of(first)
    for search in reversed(state.searches):
        if digest_of(search.detections) == wanted:
            return search
    # Where nothing was found, what was added by hand has nothing before it.
    nothing = [search for search in state.searches if not search.detections]
    return (nothing or state.searches)[-1]


def case_files(session: Path) -> tuple[Path, ...]:
    """The cases that a session has kept, in the order in which they were.

    Raises:
        FileError: their folder cannot be read.
    """
    folder = session / FOLDER
    if not is_folder(folder):
        return ()
    try:
        return tuple(sorted(path for path in folder.iterdir() if CASE_NAME.fullmatch(path.name)))
    except OSError as error:
        raise FileError(folder, error.strerror or "cannot be read") from None

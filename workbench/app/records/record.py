"""Entries as bytes for the journal, and back: canonical form as JSON, large arrays as files.

The first record of a session names its cell; every other one holds a command, who gave it
and when, and what the state was afterwards.  So people can read a session without this
program and `replay` can check that it still computes the same.
"""

import functools
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from workbench import __version__
from workbench.app.core import commands
from workbench.app.core.command import Command, Entry
from workbench.app.core.cycle.jobs import JobEnded, TaskResult
from workbench.app.core.cycle.scanning import UseObservations
from workbench.app.core.people import MACHINES, Role
from workbench.app.core.state import State
from workbench.app.records.forms import Content, ReadFile, large_arrays, restore_value
from workbench.formats.files.json_pieces import encode_json
from workbench.model.calibration import BallScan, PlateObservation
from workbench.model.cell import Cell, Tool
from workbench.model.derived.by_recipe import kit_of
from workbench.model.digest import canonical, digest_of
from workbench.model.errors import JobCancelled, JournalError, WorkbenchError
from workbench.model.messages.catalogue import message_of
from workbench.model.part import Part
from workbench.model.plan import PlanResult
from workbench.model.prediction import Emptying
from workbench.model.scan import Detection, Scan

SESSION = "Session"
SESSION_FORMAT = "workbench-session/1"

COMMANDS: Mapping[str, type[Command]] = {
    **{kind.__name__: kind for kind in commands.COMMANDS},
    "UseSightings": UseObservations,
}
"""The commands by their names on record; those of older sessions are among them."""

RESULTS: Mapping[Any, str] = {
    Scan: "scan",
    tuple[Detection, ...]: "detections",
    PlanResult: "plan",
    PlateObservation: "sighting",
    BallScan: "balls",
    Part: "part",
    Tool: "tool",
    Emptying: "emptying",
}
"""What a record calls the results of jobs; an error is reported by its type and text."""


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """What goes into the journal: kind of entry, body (JSON) and files (SHA-256 -> bytes)."""

    kind: str
    body: bytes
    files: Mapping[str, Content]


@dataclass(frozen=True, slots=True, eq=False)
class CommandForm:
    """A command ready to be written; made apart, as the arrays of a scan take a while.

    `form` is its JSON.
    """

    kind: str
    form: bytes
    files: Mapping[str, Content]


def session_record(cell: Cell, at: float, after: Mapping[str, Any] | None = None) -> Record:
    """The first record of a session: which workbench, which cell, and when.

    Args:
        cell: that it begins with.
        at: seconds since the epoch.
        after: names the session before it, if somebody said so.
    """
    body = {
        "format": SESSION_FORMAT,
        "workbench": __version__,
        "at": at,
        "cell": cell.name,
        "cell_digest": cell.digest,
        "value": canonical(cell),
    }
    if after is not None:
        body["follows"] = dict(after)
    return Record(SESSION, _json(body), large_arrays(cell))


def command_form(command: Command) -> CommandForm:
    """The form of a command: everything of a record that does not depend on the state."""
    if isinstance(command, JobEnded):
        form = {"number": command.number, "result": _result_form(command.result)}
    else:
        form = canonical(command)
    return CommandForm(type(command).__name__, _json(form), large_arrays(command))


def entry_record(entry: Entry, command: CommandForm, after: State) -> Record:
    """The record of an entry.

    Args:
        entry: what is to be written.
        command: the form of the entry's command.
        after: the state that follows from it.
    """
    begins = _json({"at": entry.at, "actor": entry.actor})
    body: dict[str, Any] = {
        "after": summary(after),
        "approval": None if after.approval is None else canonical(after.approval),
    }
    if entry.actor not in MACHINES:
        body["role"] = str(entry.role)
    if entry.joints:
        body["joints"] = dict(entry.joints)
    whole = b'%s,"command":%s,%s' % (begins[:-1], command.form, _json(body)[1:])
    return Record(command.kind, whole, command.files)


def summary(state: State) -> Mapping[str, Any]:
    """What has to come out the same when a session is computed again."""
    return {
        "phase": str(state.phase),
        "cell": state.cell.digest,
        "message": str(state.message),
        "job": None if state.job is None else state.job.number,
        "scan": None if state.scan is None else state.scan.digest,
        "plan": None if state.plan is None else state.plan.digest,
        # Of no row nothing is written, as before there were rows.
        "row": [proven_plan.plan.digest for proven_plan in state.row] or None,
        "sent_before": [proven_plan.plan.digest for proven_plan in state.sent_before] or None,
        "proof": None if state.proof is None else state.proof.digest,
        "approval": None if state.approval is None else state.approval.digest,
        "receipts": len(state.receipts),
        "ahead": None if state.ahead is None else len(state.ahead.brought),
        "parts_placed": state.parts_placed,
        "on_pallets": len(state.placed),
        "watched": list(state.watched),
        "words": [vote.actor for vote in state.votes],
        "failures": state.failures,
        "avoided": len(state.avoided),
        # Nobody is written as nothing at all: sessions from before there was control say as much.
        "control": state.control or None,
        "ran": None if state.ran is None else state.ran.digest,
        "changed": list(map(str, state.changed)) or None,
        "emptied": None if state.emptying is None else _digest_of(state.emptying),
        "asking": list(state.asking) or None,
        "kit": _kit(state),
    }


def _kit(state: State) -> Mapping[str, int] | None:
    if not kit_of(state.cell):
        return None
    kit = state.kit
    return {
        "recipe": state.cell.recipe,
        "parts": len(kit.parts),
        "complete": kit.complete,
        "incomplete": kit.incomplete,
    }


@functools.lru_cache(maxsize=2)
def _digest_of(emptying: Emptying) -> str:
    """Worked out once: every entry of a motion has it."""
    return digest_of(emptying)


def entry_of(
    number: int, kind: str, body: bytes, read: ReadFile
) -> tuple[Entry, Mapping[str, Any]]:
    """The entry that a record holds, and the summary of the state after it.

    Args:
        number: of the entry.
        kind: of the record.
        body: of the record.
        read: gives the files of the journal.

    Raises:
        JournalError: the record cannot be understood.
    """
    if kind not in COMMANDS:
        known = ", ".join(COMMANDS)
        raise JournalError(f"entry {number}: kind {kind!r} is not known; there are {known}")
    try:
        content = json.loads(body)
        command = _command(kind, content["command"], read)
        joints = content.get("joints", {})
        # Sessions from before there were roles: whoever acted could do everything.
        role = Role(content.get("role", Role.ENGINEER))
        entry = Entry(number, content["at"], content["actor"], command, joints, role)
        return entry, content["after"]
    except (
        AttributeError,
        KeyError,
        RecursionError,
        TypeError,
        ValueError,
        WorkbenchError,
    ) as error:
        raise JournalError(f"entry {number} ({kind}) cannot be read: {error}") from error


def check_session(kind: str, body: bytes, cell: Cell) -> None:
    """See that a session's first record is one, and that it ran with this cell.

    Raises:
        JournalError: it is not, or it did not.
    """
    try:
        content: Any = json.loads(body) if kind == SESSION else None
        stated, digest = content["format"], content["cell_digest"]
    except (KeyError, TypeError, ValueError) as error:
        raise JournalError(f"entry 1 ({kind}) is not the beginning of a session") from error
    if stated != SESSION_FORMAT:
        raise JournalError(f"the session has format {stated!r}, expected {SESSION_FORMAT!r}")
    if digest != cell.digest:
        raise JournalError(
            f"the session ran with the cell {digest[:12]}, not with {cell.name} as it is now "
            f"({cell.digest[:12]})"
        )


def _result_form(result: TaskResult) -> Any:
    if isinstance(result, WorkbenchError):
        error = {"type": type(result).__name__, "text": str(result)}
        return {"error": {**error, "said": result.message.form}}
    kind = RESULTS.get(type(result), "detections")
    return {kind: canonical(result)}


def _command(kind: str, form: Any, read: ReadFile) -> Command:
    if kind == JobEnded.__name__:
        return JobEnded(form["number"], _result(form["result"], read))
    return restore_value(COMMANDS[kind], form, read)


def _result(form: Mapping[str, Any], read: ReadFile) -> TaskResult:
    ((kind, content),) = form.items()
    if kind == "error":
        cancelled = content["type"] == JobCancelled.__name__
        # Older sessions have the text alone.
        why = message_of(content.get("said", content["text"]))
        return (JobCancelled if cancelled else WorkbenchError)(why)
    for result, name in RESULTS.items():
        if name == kind:
            return restore_value(result, content, read)
    raise ValueError(f"a result of kind {kind!r} is not known")


def _json(body: Mapping[str, Any]) -> bytes:
    return encode_json(body, allow_nan=True)

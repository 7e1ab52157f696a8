"""All errors that a person can correct, as one tree.

    WorkbenchError
    |-- InputError        A file, an argument or a message that cannot be used.
    |   |-- FileError     The same, with the file named.
    |   `-- CommandRefused  A command that the rules do not allow now.
    |       `-- NotAllowed  A command that a person of this role may never give.
    |-- LinkError         The controller or a scanner cannot be reached, or broke off.
    |   `-- ProtocolError It answered something that the protocol does not know.
    |-- JobCancelled      A person ended a long task.
    `-- JournalError      The journal cannot be written, or was changed from outside.

An expected failure of planning is not an error but a value: see `Verdict`.
Messages name the file, the key, the value, what was expected and what is available.
"""

from pathlib import Path
from typing import Any

from workbench.model.messages.devices import DeviceText
from workbench.model.messages.files import FileText
from workbench.model.messages.message import Message, as_message


class WorkbenchError(Exception):
    """Root of all errors that the workbench raises on purpose; `str` gives the English text."""

    def __init__(self, why: Message | str = ""):
        super().__init__(str(why))
        self._why = as_message(why)

    def __reduce__(self) -> tuple[Any, ...]:
        # Errors cross the border to the worker process and back with their messages.
        return (type(self), (self._why,))

    @property
    def message(self) -> Message:
        """What went wrong, for people in their language."""
        return self._why


class InputError(WorkbenchError):
    """Something given from outside cannot be used as it is."""


class FileError(InputError):
    """A file cannot be used; the message starts with its path, `problem` is the rest of it.

    A `problem` without an id is a detail for who writes such files, in English.
    """

    def __init__(self, path: Path | str, problem: Message | str):
        self.path = str(path)
        self.problem = FileText.INVALID(detail=problem) if isinstance(problem, str) else problem
        super().__init__(FileText.PROBLEM(path=self.path, problem=self.problem))

    def __reduce__(self) -> tuple[type["FileError"], tuple[str, Message]]:
        # Those that derive from it have constructors of their own.
        return (FileError, (self.path, self.problem))


class CommandRefused(InputError):
    """The rules do not admit this command in this state, or not from this actor."""


class NotAllowed(CommandRefused):
    """A command that is for people of another role, whatever the state."""


class NotRecorded(CommandRefused):
    """A command that was in order, and was not carried out since it cannot be written down."""


class LinkError(WorkbenchError):
    """A device cannot be reached, did not answer in time, or broke off."""


class ProtocolError(LinkError):
    """A device sent something that the protocol does not know.

    What it was is for who programs the device, in English.
    """

    def __init__(self, why: Message | str = ""):
        super().__init__(DeviceText.PROTOCOL(detail=why) if isinstance(why, str) else why)


class JobCancelled(WorkbenchError):
    """A person cancelled the task."""


class JournalError(WorkbenchError):
    """The journal cannot be written or does not agree with itself."""

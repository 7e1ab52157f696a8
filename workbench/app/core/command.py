"""What a command is: its values, its right, its check and what it does, in one class.

A subject (scanning, rows, control) is a file with its commands and what they need.
`decide.check_allowed` asks `check`, `decide.decide` calls `apply`; neither knows any single
command.
"""

from abc import ABC, abstractmethod
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import ClassVar

from workbench.app.core.effects import Effect
from workbench.app.core.people import Role
from workbench.app.core.state import Phase, State
from workbench.model.errors import CommandRefused, InputError
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message
from workbench.model.messages.states import NextText

EVERY_PHASE = frozenset(Phase)
SAFE = EVERY_PHASE - {Phase.SENDING, Phase.FAULT}

Decision = tuple[State, tuple[Effect, ...]]
"""The state after a command, and what has to be set in motion."""


@dataclass(frozen=True, slots=True)
class Right:
    """When a command is allowed; `says` names it in refusals, `otherwise` states what is missing.

    People give commands, except those `by_machine`; commands `by_anybody` come from both.
    `also_by` is the only machine that may give a command of people.  `role` is the lowest role that
    a person needs.  While a person is in control, only that person may give commands, except those
    `without_control`.  A command that `changes_cell` is refused while a recipe is chosen, a command
    that `plans` while the tool of an arm is unknown.
    """

    says: CommandText
    phases: frozenset[Phase]
    otherwise: NextText | None = None
    beside_job: bool = False
    by_machine: bool = False
    by_anybody: bool = False
    also_by: str | None = None
    role: Role = Role.OPERATOR
    without_control: bool = False
    changes_cell: bool = False
    plans: bool = False


@dataclass(frozen=True, slots=True)
class Asked:
    """Who requests a command, when, and where the robot is.

    `actor` is the name of a person, or one of `MACHINES`; `now` is in seconds since the epoch.
    `joints` are the positions that the robot reports (name -> rad), empty when it reports none.
    """

    actor: str
    now: float
    joints: Mapping[str, float]
    role: Role


class Command(ABC):
    """Something that a person or a machine can ask of the workbench; a frozen value."""

    __slots__ = ()

    right: ClassVar[Right]

    @classmethod
    def is_in_phase(cls, state: State) -> bool:
        """Whether the cycle stands where this kind of command is in order."""
        return state.phase in cls.right.phases

    @classmethod
    def obstacle(cls, state: State) -> Message | None:
        """What else is in the way of this kind of command, whatever its values; else None."""
        return None

    # Most commands have nothing to check but who gives them, and when.
    def check(self, state: State, asked: Asked) -> None:  # noqa: B027
        """Check that the values fit the state.

        Raises:
            CommandRefused: they do not, with a sentence for who asked.
        """

    @abstractmethod
    def apply(self, state: State, entry: "Entry") -> Decision:
        """The state after the command, which `check` has allowed; a pure function."""


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A command with its number, its time [s since the epoch], its author and the author's role.

    Clock, user and the robot's pose enter only here; everything else is computed from entries.
    `joints` (name -> rad) are the reported joints where a rule compares them: with the start of a
    plan, the view of a scan, or for a drop back.  Otherwise, and without a report, they are empty.
    The `role` of a machine has no meaning.
    """

    number: int
    at: float
    actor: str
    command: Command
    joints: Mapping[str, float] = field(default_factory=dict[str, float])
    role: Role = Role.ENGINEER


@contextmanager
def refuse_input() -> Generator[None]:
    """Refuse a command where the block finds its values unusable.

    Raises:
        CommandRefused: the block raised an `InputError`; the message is the same.
    """
    try:
        yield
    except InputError as error:
        raise CommandRefused(error.message) from error


def refuse(problem: Message | None) -> None:
    """Refuse a command when there is a problem; None means that there is none.

    Raises:
        CommandRefused: with the problem.
    """
    if problem is not None:
        raise CommandRefused(problem)

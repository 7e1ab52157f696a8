"""Who runs statements, and how a statement ends."""

from dataclasses import dataclass
from typing import Any, Protocol

from workbench.formats.rapid.problems import RapidError, RapidStop
from workbench.formats.rapid.symbols import Frame, Node, Routine, Run

Key = tuple[str, int, int]
"""Module, line and column of a statement."""

LEAVES = ("return_", "raise_", "retry", "trynext", "exit", "goto")
"""After these nothing is reached in the same block."""


class Host(Protocol):
    """Runs the program: receives each statement's start and all that only a controller can do."""

    def step(self, key: Key) -> None:
        """A statement begins."""
        ...

    def hold(self, why: RapidStop) -> None:
        """The program cannot go on, and stays where it is until it is started again."""
        ...

    def exit(self) -> None:
        """EXIT: the program ends."""
        ...

    def connect(self, place: Any, trap: Routine) -> None:
        """CONNECT: an interrupt gets its trap routine."""
        ...


def act_checked(act: Run, frame: Frame) -> Any:
    """Do something; what Python cannot compute is an execution error."""
    try:
        return act(frame)
    except OverflowError:
        raise RapidError("ERR_NUM_OVERFLOW") from None
    except RecursionError:
        raise RapidStop("routines call each other without end") from None
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        raise RapidStop(f"an argument makes no sense: {error}") from error


@dataclass(frozen=True)
class Jump:
    """How GOTO ends a statement: the block that has the label goes on there."""

    label: str


def no_action(frame: Frame) -> None:
    """What a label does."""


def labels_of(block: Node) -> dict[str, int]:
    """Where labels stand among the statements of a block, by small name."""
    rows = enumerate(block.children)
    return {str(node.children[0]).lower(): k for k, node in rows if node.data == "label"}

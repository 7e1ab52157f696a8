"""Piles that are emptied in simulation."""

from dataclasses import dataclass
from typing import ClassVar, get_args

from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right
from workbench.app.core.people import Role
from workbench.app.core.state import State
from workbench.app.core.tasks import begin_task
from workbench.app.core.value_checks import (
    MOST_PARTS,
    MOST_PILES,
    SEED_LIMIT,
    check_among,
    check_integer,
)
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused
from workbench.model.messages.commands import CommandText, NameText
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import ChangeRefusal
from workbench.model.messages.states import StateText
from workbench.model.prediction import CHANGE_KINDS, Emptying, Seen


@dataclass(frozen=True, slots=True, eq=False)
class TryEmptying(Command):
    """Empty piles in simulation, in the cell as it is; nothing real has to do with it.

    `kinds` are the parts that fall, one of each in turn, of those that the cell picks; empty: all
    of them.  `count` of them make a pile, and of `piles` each has the next seed.  `changes` are
    kinds of single changes of the cell (`CHANGE_KINDS`) with which the same piles are emptied too.
    """

    # It moves nothing, but it keeps the worker for itself, and is about how the cell is made.
    right: ClassVar[Right] = Right(CommandText.TRY_EMPTYING, SAFE, role=Role.ENGINEER)

    kinds: tuple[str, ...] = ()
    count: int = 15
    piles: int = 3
    seed: int = 0
    seen: Seen = "truth"
    changes: tuple[str, ...] = ()

    def check(self, state: State, asked: Asked) -> None:
        check_emptying(state.cell, self)

    def apply(self, state: State, entry: Entry) -> Decision:
        says = StateText.EMPTYING(piles=self.piles, parts=self.count)
        return begin_task(state, entry, "emptying", {"command": self}, says)


def check_emptying(cell: Cell, command: TryEmptying) -> None:
    """Piles of parts that the cell picks, no more of them than can be emptied in one task.

    Raises:
        CommandRefused: other parts, too many or too few, or changes of a kind that there is not.
    """
    known = tuple(part.name for part in cell.parts)
    for kind in command.kinds:
        check_among("part", kind, known)
    if len(set(command.kinds)) < len(command.kinds):
        raise CommandRefused(ChangeRefusal.PART_TWICE(parts=command.kinds))
    check_integer("parts", command.count, 1, MOST_PARTS)
    check_integer("piles", command.piles, 1, MOST_PILES)
    check_integer("seed", command.seed, 0, SEED_LIMIT - MOST_PILES)
    check_among("seen", command.seen, get_args(Seen))
    for kind in command.changes:
        check_among(NameText.KIND_OF_CHANGE, kind, CHANGE_KINDS)


def emptying_words(found: Emptying) -> Message:
    """What came of piles emptied in simulation, in one sentence."""
    plain = found.plain
    taken, parts = sum(pile.taken for pile in plain), sum(pile.parts for pile in plain)
    emptied = StateText.EMPTIED(taken=taken, parts=parts, piles=len(plain))
    tried = len({pile.task.change for pile in found.piles} - {None})
    return emptied if not tried else StateText.CHANGES_TRIED(emptied=emptied, count=tried)

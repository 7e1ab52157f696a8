"""Piles emptied one after the other, with single changes of the cell where that is wanted."""

from workbench.app.core.cell.emptying import TryEmptying
from workbench.app.emptying.changes import apply_change
from workbench.app.emptying.empty import empty_pile, fallen
from workbench.app.emptying.film import Film, Filmed, Numbered, Shot
from workbench.app.emptying.what_if import tasks_with_changes
from workbench.app.picking.pile_check import check_pile, with_kinds
from workbench.model.cell import Cell
from workbench.model.messages.message import Message
from workbench.model.messages.parts import PileText
from workbench.model.messages.work import ProgressText
from workbench.model.prediction import TOGETHER, EmptiedPile, Emptying, PileTask
from workbench.plugins.progress import Cancelled, Report


def emptied_piles(cell: Cell, command: TryEmptying, report: Report, cancelled: Cancelled) -> Filmed:
    """What comes of the piles that a command wants, and a film of each in the cell as it is.

    Args:
        cell: that is tried, as it is now.
        command: how many piles of what, and which changes are tried besides.
        report: called with which pile is emptied, and how far that is.
        cancelled: asked now and then whether to give up.

    Raises:
        InputError: the parts do not fit, or nothing can take them; see `check_pile`.
        JobCancelled: `cancelled` said so.
    """
    plain = with_kinds(cell, command.kinds)
    check_pile(plain, command.count)
    names = TOGETHER.join(part.name for part in plain.parts)
    tasks = [
        PileTask(cell.name, names, command.count, seed, command.seen)
        for seed in range(command.seed, command.seed + command.piles)
    ]
    if command.changes:
        report(0.0, ProgressText.CHANGES())
        tasks = tasks_with_changes(plain, tasks, command.changes)
    piles: list[EmptiedPile] = []
    films: list[Film] = []
    tried = plain
    for number, task in enumerate(tasks):
        if number and task.change != tasks[number - 1].change:
            tried = apply_change(plain, task.change)
        says = _message(task, number % command.piles + 1, command.piles)

        def report_step(
            done: float, note: Message | str, number: int = number, says: Message = says
        ) -> None:
            report((number + done) / len(tasks), PileText.STEP(pile=says, step=note))

        report_step(0.0, ProgressText.FALLING())
        pile = fallen(plain, tried, task)
        shots: list[Shot] = []
        piles.append(
            empty_pile(
                tried, task, pile, report=report_step, cancelled=cancelled, film=shots.append
            )
        )
        if not task.change:
            films.append(_film(task, tuple(enumerate(pile)), tuple(shots)))
    return Filmed(Emptying(cell.digest, tuple(piles)), tuple(films))


def _film(task: PileTask, pile: Numbered, shots: tuple[Shot, ...]) -> Film:
    return Film(task, pile, shots, shots[-1].after if shots else pile)


def _message(task: PileTask, number: int, piles: int) -> Message:
    pile = PileText.OF_TASK(number=number, count=piles)
    return PileText.WITH_CHANGE(change=task.change, pile=pile) if task.change else pile

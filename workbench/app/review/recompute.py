"""A session's results computed again from what it has kept, and how alike they are."""

from collections.abc import Iterator
from dataclasses import dataclass

from workbench.app.core.cycle.correcting import CORRECT
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.decide import decide
from workbench.app.core.effects import StartJob
from workbench.app.core.state import State
from workbench.app.emptying.film import Filmed
from workbench.app.records.replay import replay
from workbench.app.records.sessions import cell_of
from workbench.app.review.likeness import Likeness, resemblance
from workbench.app.runtime.work import JOBS
from workbench.journal.journal import Journal
from workbench.model.cell import Cell
from workbench.model.errors import WorkbenchError
from workbench.model.scan import LocalizationResult
from workbench.plugins.progress import never, silent


@dataclass(frozen=True, slots=True)
class Comparison:
    """One task computed again: the number of the entry that began it, and what came of it."""

    number: int
    task: str
    likeness: Likeness
    says: str


def recompute_tasks(journal: Journal) -> Iterator[Comparison]:
    """Every task of a session that ended well, run again on the inputs that were recorded.

    No result enters the next task: parts are searched for in the scan that was kept.  A scan of a
    real scanner cannot be taken again and is passed over; a simulated one is.

    Raises:
        JournalError: the session cannot be computed again at all; see `replay`.
    """
    cell = cell_of(journal)
    before = State(cell, number=1, saved=cell.digest)
    begun: dict[int, tuple[Cell, StartJob]] = {}
    for entry, after in replay(journal, cell):
        if isinstance(entry.command, JobEnded) and entry.command.number in begun:
            comparison = _compare(*begun.pop(entry.command.number), entry.command.result)
            if comparison is not None:
                yield comparison
        # The end of a task may begin the next one, in another bin of the cell.
        for effect in decide(before, entry)[1]:
            if isinstance(effect, StartJob):
                begun[effect.number] = (after.cell, effect)
        before = after


def _compare(cell: Cell, job: StartJob, kept: object) -> Comparison | None:
    if (
        isinstance(kept, WorkbenchError)
        or job.name in ("import", "tool", CORRECT)  # made of files that are not on record
        or (job.name in ("scan", "sight", "balls") and cell.scanner.source != "simulated")
    ):
        return None
    try:
        again = JOBS[job.name](cell, job.arguments, silent, never)
    except WorkbenchError as error:
        return Comparison(job.number, job.name, Likeness.OTHER, f"failed: {error}")
    if isinstance(again, LocalizationResult):
        again = again.detections
    if isinstance(again, Filmed):
        again = again.emptying
    found = resemblance(cell, kept, again)
    return Comparison(job.number, job.name, found.likeness, found.says)

"""A library filled in a process of its own: it takes a minute, and no page may wait for it.

Imported by that process as well: its `JOBS` are here.
"""

from collections.abc import Mapping, Sequence
from threading import Event
from typing import Any

from workbench.app.filling.fill import Filled, filled
from workbench.app.filling.for_remaining import Proposal, families_for
from workbench.app.runtime.own_process import in_own_process
from workbench.app.runtime.readiness import make_ready
from workbench.app.runtime.worker import JobFunction
from workbench.app.statistics.remaining import RemainingPart
from workbench.model.cell import Cell
from workbench.model.part import Part
from workbench.plugins.progress import Cancelled, Report


def fill(cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled) -> Filled:
    """The families of grasps for `part` in a cell."""
    make_ready(report, ("planning",))
    return filled(cell, arguments["part"], report=report, cancelled=cancelled)


def propose(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> Proposal:
    """The families of grasps for parts of the kind `name` that are `left`."""
    make_ready(report, ("planning",))
    return families_for(
        cell, arguments["name"], arguments["left"], report=report, cancelled=cancelled
    )


JOBS: Mapping[str, JobFunction] = {"fill": fill, "propose": propose}


def fill_apart(cell: Cell, part: Part, report: Report, given_up: Event) -> Filled:
    """See `filled`; until it has come, whoever asks waits in this thread.

    Args:
        cell: whose bin, arms and tools are used.
        part: with its library.
        report: called from another thread with the progress.
        given_up: set by who does not want to wait any longer.

    Raises:
        WorkbenchError: nothing can be filled, or the process has ended.
        JobCancelled: it was given up.
    """
    return in_own_process(__name__, "fill", cell, {"part": part}, report, given_up)


def propose_apart(
    cell: Cell, name: str, left: Sequence[RemainingPart], report: Report, given_up: Event
) -> Proposal:
    """See `families_for` and `fill_apart`.

    Args:
        cell: with its parts as they are now.
        name: of a kind of part.
        left: parts that stayed in the bin.
        report: takes the progress, from another thread.
        given_up: set by who does not want to wait any longer.

    Raises:
        WorkbenchError: nothing can be proposed, or the process has ended.
        JobCancelled: it was given up.
    """
    arguments = {"name": name, "left": tuple(left)}
    return in_own_process(__name__, "propose", cell, arguments, report, given_up)

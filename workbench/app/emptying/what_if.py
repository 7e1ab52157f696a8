"""Which single change of a cell gains most: the same piles emptied with each, and ranked."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any

from workbench.app.emptying.changes import changes_of
from workbench.app.emptying.summary import summary
from workbench.model.cell import Cell
from workbench.model.messages.message import Message
from workbench.model.prediction import EmptiedPile, PileTask


def tasks_with_changes(
    cell: Cell, tasks: Sequence[PileTask], kinds: Collection[str]
) -> list[PileTask]:
    """The tasks, and after them the same piles with every change of these kinds.

    Changes that change nothing in the cell are left out.
    """
    wanted = [
        change.said
        for change in changes_of(cell)
        if change.kind in kinds and change.made(cell) is not None
    ]
    return [
        *tasks,
        *(replace(task, change=said, bounds=False) for said in wanted for task in tasks),
    ]


def rank_changes(
    scenes: Sequence[EmptiedPile], *, scan_seconds: float, approval_seconds: float
) -> list[dict[str, Any]]:
    """What each change brought, the most first, as it is printed as JSON.

    Args:
        scenes: of the piles without a change and with each.
        scan_seconds: [s] see `summary`.
        approval_seconds: [s] see `summary`.
    """
    by_change: dict[Message | None, list[EmptiedPile]] = {}
    for scene in scenes:
        by_change.setdefault(scene.task.change, []).append(scene)
    found = {
        said: summary(some, scan_seconds=scan_seconds, approval_seconds=approval_seconds)
        for said, some in by_change.items()
    }
    before = found.pop(None)
    rows = [
        {
            "change": str(said),
            "said": said.program_form,
            "taken_share_before": before["taken_share"],
            "taken_share": answer["taken_share"],
            "parts_gained": answer["taken"] - before["taken"],
            "taken_by_scene": [scene["taken"] for scene in answer["scenes"]],
            "failed_picks": answer["failed_picks"],
            "touches": answer["touches"],
            "cycles": answer["cycles"],
            "motion_seconds": answer["motion_seconds"],
            "left_by_reason": answer["left_by_reason"],
        }
        for said, answer in found.items()
        if said is not None
    ]
    # What the clock says is no part of the order: it is the same each time.
    return sorted(
        rows,
        key=lambda row: (
            -row["parts_gained"], row["failed_picks"] + row["touches"], row["motion_seconds"],
            row["change"],
        ),
    )  # fmt: skip

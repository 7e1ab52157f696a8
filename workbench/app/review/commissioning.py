"""What it takes until a cell is commissioned, and how much of it is done.

Made from the state and the statistics of a session, so page, HTTP and report show the same.
"""

import enum
from dataclasses import dataclass

from workbench.app.core.state import State
from workbench.app.statistics.statistics import Statistics
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.messages.cells import CommissioningText
from workbench.model.messages.message import Message
from workbench.model.scan import Scan

DAY = 24 * 3600.0
"""[s]"""

MOST_PICKS = 1_000_000
"""More are not counted."""


class Step(enum.StrEnum):
    """A step of commissioning, in the order in which people take them."""

    LOAD = "load"
    CALIBRATION = "calibration"
    GRASPS = "grasps"
    SCAN = "scan"
    PARTS = "parts"
    PLAN = "plan"
    PICK = "pick"
    SAVED = "saved"


@dataclass(frozen=True, slots=True)
class CheckedStep:
    """A step, whether it is done, and what was verified or is missing."""

    step: Step
    is_done: bool
    says: Message


@dataclass(frozen=True, slots=True)
class Targets:
    """What was agreed: the `share`, 0 to 1, of the last `picks` that is taken, each in `seconds`.

    None for a time leaves it open.
    """

    picks: int = 200
    share: float = 0.98
    seconds: float | None = None

    def check(self) -> None:
        """Look whether they can be met at all.

        Raises:
            InputError: one of them cannot.
        """
        if not 1 <= self.picks <= MOST_PICKS:
            raise InputError(f"{self.picks} picks are not from 1 to {MOST_PICKS:,}")
        if not 0.0 < self.share <= 1.0:
            raise InputError(f"a share of {self.share:g} is not above 0 and at most 1")
        if self.seconds is not None and not 0.0 < self.seconds < float("inf"):
            raise InputError(f"{self.seconds:g} s is no time for a part")


def checklist(state: State, statistics: Statistics, now: float) -> tuple[CheckedStep, ...]:
    """Every step of commissioning, checked.

    Args:
        state: of the session.
        statistics: of the same session; a cycle that has ended shows that its steps work.
        now: [s since the epoch], for the age of the calibration.
    """
    has_run = any(cycle.end == "done" for cycle in statistics.cycles)
    picks = statistics.picks
    text = CommissioningText
    found = state.detections or ()
    parts = text.PARTS(count=len(found)) if found else text.PARTS_BEFORE()
    has_plan = state.proof is not None and state.proof.holds
    picked = text.PICKS(picked=statistics.picked, count=len(picks))
    return (
        _load(state.cell),
        _calibration(state.cell, state.scan, now),
        _grasps(state.cell),
        _of(Step.SCAN, state.scan is not None or has_run, text.SCAN(), text.NO_SCAN()),
        _of(Step.PARTS, bool(found) or has_run, parts, text.NO_PARTS()),
        _of(Step.PLAN, has_plan or has_run, text.PLAN(), text.NO_PLAN()),
        _of(Step.PICK, statistics.picked > 0, picked, text.NO_PICK()),
        _of(Step.SAVED, state.is_saved, text.SAVED(), text.NOT_SAVED()),
    )


def next_step(checked: tuple[CheckedStep, ...]) -> Step | None:
    """The first step that is not done; None when all are."""
    return next((each.step for each in checked if not each.is_done), None)


def _of(step: Step, is_done: bool, done: Message, missing: Message) -> CheckedStep:
    return CheckedStep(step, is_done, done if is_done else missing)


def _load(cell: Cell) -> CheckedStep:
    missing = sorted({arm.tool.name for arm in cell.arms if arm.tool.mass is None})
    done = CommissioningText.LOADS()
    return _of(Step.LOAD, not missing, done, CommissioningText.NO_LOAD(tools=missing))


def _calibration(cell: Cell, scan: Scan | None, now: float) -> CheckedStep:
    scanner, text = cell.scanner, CommissioningText
    if scanner.calibration is not None:
        days = int(max(0.0, now - scanner.calibration.at) // DAY)
        is_young = days <= scanner.calibration_days
        says = text.CALIBRATED(days=days) if is_young else text.CALIBRATION_OLD(days=days)
        return CheckedStep(Step.CALIBRATION, is_young, says)
    if scanner.source == "merged":
        # It takes no view of a scanner that is not calibrated.
        return CheckedStep(Step.CALIBRATION, True, text.MERGED())
    # A simulated scanner hangs where the cell says; the one of a scan from a file may not.
    is_simulated = scanner.source == "simulated" and (scan is None or scan.source == "simulated")
    return _of(Step.CALIBRATION, is_simulated, text.SIMULATED(), text.NOT_CALIBRATED())


def _grasps(cell: Cell) -> CheckedStep:
    text = CommissioningText
    if not cell.parts:
        return CheckedStep(Step.GRASPS, False, text.NO_PART())
    without = [
        part.name for part in cell.parts if not (part.library.grasps or part.library.searches)
    ]
    count = sum(len(part.library.grasps) for part in cell.parts)
    return _of(Step.GRASPS, not without, text.GRASPS(count=count), text.NO_GRASPS(parts=without))

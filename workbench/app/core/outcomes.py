"""What became of the parts of a plan, and which are left alone for a while after that."""

import math
from dataclasses import replace

from workbench.app.core.commands import ReportPick
from workbench.app.core.state import Avoided, Outcome, Phase, State
from workbench.model.cell import Cell
from workbench.model.scan import Detection

AVOID_SCANS = 3
"""For so many further scans a part is left alone after its pick has failed."""

AVOID_MINUTES = 10.0

SAME_PLACE = 0.015
"""[m] A part found this near to where a pick has failed is taken for the same one."""

MOST_FAILURES = 3
"""So many failed picks in a row stop the cycle until somebody has looked."""


def outcome_problem(state: State, command: ReportPick) -> str:
    """Why an outcome cannot be taken; empty when it can."""
    if state.plan is None:
        return "there is no plan whose parts were picked"
    if command.is_picked not in (True, False):
        return f"a pick has succeeded or failed, {command.is_picked!r} is neither"
    taken = [one.detection for one in state.plan.arms]
    if command.detection not in taken:
        parts = ", ".join(f"part-{number + 1}" for number in taken)
        return f"the plan does not take that part; it takes {parts}"
    for one in state.outcomes:
        if (one.detection, one.is_picked) == (command.detection, command.is_picked):
            return f"{one.by} has said so already"
    return ""


def with_outcome(state: State, command: ReportPick, actor: str, at: float) -> State:
    """The state after somebody has said what became of a part.

    A later word replaces an earlier one for the same part.

    Args:
        state: whose plan was sent.
        command: what is said.
        actor: who says it.
        at: when [s since the epoch].
    """
    if state.plan is None:
        return state
    detection = state.plan.detections[command.detection]
    outcome = Outcome(command.detection, command.is_picked, actor, command.why)
    others = tuple(one for one in state.outcomes if one.detection != command.detection)
    elsewhere = tuple(one for one in state.avoided if not _is_at(state.cell, detection, one))
    said = "was picked" if command.is_picked else "failed"
    why = f": {command.why}" if command.why else ""
    state = replace(
        state,
        outcomes=(*others, outcome),
        failures=0 if command.is_picked else state.failures + 1,
        avoided=elsewhere,
        message=f"part-{command.detection + 1} {said}, says {actor}{why}",
    )
    if not command.is_picked:
        x, y, z = (state.cell.bin.T_world_bin.inverse() * detection.T_world_part).translation
        place = (float(x), float(y), float(z))
        until = at + AVOID_MINUTES * 60.0
        mark = Avoided(detection.part, place, until, AVOID_SCANS, command.why)
        state = replace(state, avoided=(*elsewhere, mark))
    return escalated(state)


def escalated(state: State) -> State:
    """The state, stopped with a fault when a cycle ends and too many picks in a row have failed."""
    if state.phase is not Phase.DONE or state.failures < MOST_FAILURES:
        return state
    fault = (
        f"{state.failures} picks in a row have failed; look at bin, grippers and grasps before "
        "going on"
    )
    return replace(state, phase=Phase.FAULT, fault=fault, message=fault)


def after_one_more_scan(avoided: tuple[Avoided, ...], at: float) -> tuple[Avoided, ...]:
    """What is still avoided in a new scan taken at [s since the epoch]."""
    return tuple(
        replace(one, scans=one.scans - 1) for one in avoided if one.scans > 0 and at < one.until
    )


def avoided_parts(state: State, at: float) -> tuple[tuple[int, str], ...]:
    """Indices of the parts found that are left alone at [s since the epoch], and why each."""
    found: list[tuple[int, str]] = []
    for number, detection in enumerate(state.detections or ()):
        for one in state.avoided:
            if at < one.until and _is_at(state.cell, detection, one):
                why = f", {one.why}" if one.why else ""
                found.append((number, f"avoided since its pick failed{why}"))
                break
    return tuple(found)


def _is_at(cell: Cell, detection: Detection, avoided: Avoided) -> bool:
    p_bin = (cell.bin.T_world_bin.inverse() * detection.T_world_part).translation
    return detection.part == avoided.part and math.dist(p_bin, avoided.p_bin) < SAME_PLACE

"""Plans of a pile carried out: what each hand takes, and how the rest lies then."""

from dataclasses import replace

import numpy as np

from workbench.app.emptying.film import FilmedPick, Shot
from workbench.app.emptying.taking import Taking, carried_out, failure, in_turn
from workbench.app.emptying.tally import Tally
from workbench.app.picking.stations import stands_on_station
from workbench.model.cell import Cell
from workbench.model.derived.by_tcp import by_taking
from workbench.model.plan import ArmPlan, Plan
from workbench.model.prediction import PileTask
from workbench.model.scan import Detection
from workbench.perception.simulation.unloading import is_in_bin, unloaded
from workbench.planning.kinematics.chain import chain_of


def carry_out_plan(
    cell: Cell, task: PileTask, plan: Plan, lying: list[tuple[int, Detection]], tally: Tally
) -> tuple[Shot, list[int]]:
    """Take the plan's parts out of `lying`, or put them onto stations.

    Args:
        cell: of the plan.
        task: how the pile is emptied.
        plan: that is proven.
        lying: how the parts truly lie, with those on stations; is changed.
        tally: is added to.

    Returns:
        What can be shown of it, and the numbers of the plan's detections whose picks failed.
    """
    tally.motion += plan.cycle_seconds
    before, failed = tuple(lying), list[int]()
    picks: list[FilmedPick] = []
    for arm_plan in in_turn(plan):
        truth = [detection for _, detection in lying]
        meant = plan.detections[arm_plan.detection]
        taking = carried_out(cell, truth, arm_plan, meant)
        kind = _count(cell, task, plan, arm_plan, taking, tally)
        if kind:
            failed.append(arm_plan.detection)
        if taking.number is None:
            picks.append(FilmedPick(arm_plan.arm, None, arm_plan.T_tcp_part, kind, tuple(lying)))
            continue
        number, gripped = lying[taking.number]
        lying[:] = _rest(cell, task, taking, lying, tally)
        q_grasp = np.asarray(arm_plan.leg("approach").q[-1])
        T_tcp_part = (
            chain_of(cell, cell.arm(arm_plan.arm)).pose(q_grasp).actInv(gripped.T_world_part)
        )
        picks.append(
            FilmedPick(arm_plan.arm, number, T_tcp_part, kind, tuple(lying), arm_plan.station)
        )
        if arm_plan.station and not kind:
            lying.append((number, _standing(cell, plan, arm_plan, gripped)))
            tally.standing.add(number)
    if failed:
        # Whatever is in doubt ends a row.  Somebody takes away what stands on a station.
        tally.knocked_out += len(tally.standing)
        lying[:] = [entry for entry in lying if entry[0] not in tally.standing]
        tally.standing.clear()
        picks[-1] = replace(picks[-1], after=tuple(lying))
    return Shot(plan, before, tuple(picks)), failed


def _count(
    cell: Cell, task: PileTask, plan: Plan, arm_plan: ArmPlan, taking: Taking, tally: Tally
) -> str:
    """Count what came of a pick, and return how it failed; empty where it did not.

    A part on a station is taken by the next plan of the row.
    """
    kind = failure(taking, plan.detections[arm_plan.detection])
    tally.touches += taking.touches
    if plan.goes_unseen:
        tally.warned_picks += 1
        tally.warned_touches += taking.touches
    if kind:
        tally.failed[kind] += 1
    elif not arm_plan.station:
        tally.taken += 1
        tally.rolled += taking.is_turned
        tally.assembled.add(cell, task, plan, arm_plan)
    if kind or not arm_plan.station:
        tally.outcomes.append(kind)
    return kind


def _rest(
    cell: Cell, task: PileTask, taking: Taking, lying: list[tuple[int, Detection]], tally: Tally
) -> list[tuple[int, Detection]]:
    """How the other parts lie once one was lifted; those that leave the bin are counted."""
    assert taking.number is not None
    rest = [entry for k, entry in enumerate(lying) if k != taking.number]
    number, _ = lying[taking.number]
    if number in tally.standing:
        tally.standing.remove(number)
        return rest
    if task.settles:
        truth = [detection for _, detection in lying]
        settled = unloaded(cell, truth, taking.number, taking.way)
        rest = [(number, found) for (number, _), found in zip(rest, settled, strict=True)]
    stays = [
        (number, found)
        for number, found in rest
        if is_in_bin(cell.bin, cell.part(found.part), found.T_world_part)
    ]
    tally.knocked_out += len(rest) - len(stays)
    return stays


def _standing(cell: Cell, plan: Plan, arm_plan: ArmPlan, gripped: Detection) -> Detection:
    """A part on a station: off where the plan has it as it is off in the hand."""
    taking = by_taking(cell, arm_plan)
    q_grasp = np.asarray(arm_plan.leg("approach").q[-1])
    T_world_tcp = chain_of(taking, taking.arm(arm_plan.arm)).pose(q_grasp)
    T_planned_part = arm_plan.T_tcp_part.actInv(T_world_tcp.actInv(gripped.T_world_part))
    T_world_planned = stands_on_station(cell, plan, arm_plan)
    assert T_world_planned is not None
    return replace(gripped, T_world_part=T_world_planned * T_planned_part)

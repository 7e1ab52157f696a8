"""What may happen now: pure checks; every refusal says what to do instead."""

import math
from typing import Any, assert_never

import numpy as np
import pinocchio as pin

from workbench.app.commands import (
    AcknowledgeFault,
    Approve,
    CancelJob,
    CellRead,
    ChangeCell,
    Command,
    EmptyPallets,
    FindParts,
    JobEnded,
    LinkEnded,
    MakePlan,
    RedoCell,
    SaveCell,
    SendPlan,
    Sent,
    Stop,
    TakeScan,
    UndoCell,
    UseDetections,
    UseScan,
)
from workbench.app.rights import MACHINES, RIGHTS, obstacle
from workbench.app.state import State
from workbench.model.cell import ORDER_NAMES, PLANNER_NAMES, Cell, Wishes
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, InputError
from workbench.model.plan import UNSIGNED, Plan, Proof, Strategy
from workbench.model.release import Approval
from workbench.model.scan import Detection

MOST_PARTS = 30
SEED_LIMIT = 2**31
LONGEST_NAME = 80
LONGEST_TEXT = 200
FARTHEST = 20.0
"""[m] Nothing of a cell stands further from its origin."""
MOST_ITERATIONS = 100_000
LARGEST_MARGIN = 0.2
"""[m]"""
STRATEGIES = ("auto", *(str(strategy) for strategy in Strategy), "both")
"""`auto` takes what the controller can run; `both` plans with the arms one after the other and
at once, and compares."""


def allowed(state: State, command: Command, actor: str, now: float) -> None:
    """Let a command pass, or say why not.

    Args:
        state: as it is.
        command: what is asked for.
        actor: who asks: a person's name, or one of `MACHINES`.
        now: seconds since the epoch.

    Raises:
        CommandRefused: with a sentence for the one who asked.
    """
    _check_actor(command, actor)
    if problem := obstacle(state, type(command)):
        raise CommandRefused(problem)
    match command:
        case TakeScan(seed=seed, parts=parts):
            _check_integer("seed", seed, 0, SEED_LIMIT - 1)
            _check_integer("parts", parts, 1, MOST_PARTS)
        case FindParts(seed=seed):
            _check_integer("seed", seed, 0, SEED_LIMIT - 1)
            if state.scan is None:
                raise CommandRefused("finding parts is not possible now: take a scan first")
        case UseDetections(detections=detections, says=says):
            _check_text("says", says)
            _check_detections(state.cell, detections)
        case MakePlan(strategy=strategy, threshold=threshold, seed=seed, wishes=wishes):
            _check_integer("seed", seed, 0, SEED_LIMIT - 1)
            _check_wishes(state.cell, wishes)
            _check_number("threshold", threshold, 0.0, 1.0, "m")
            _check_among("strategy", strategy, STRATEGIES)
        case Approve(plan_digest=digest):
            plan = _named_plan(state, digest)
            _check_scene(state, plan)
            if state.proof is None:
                raise CommandRefused("the plan has no proof, so it cannot be approved")
            approve(state.cell, plan, state.proof, actor, now)
        case SendPlan(plan_digest=digest):
            plan = _named_plan(state, digest)
            if problem := staleness(state.approval, plan, state.cell, state.scene_digest, now):
                raise CommandRefused(problem)
        case ChangeCell(cell=cell, says=says):
            _check_text("says", says)
            _check_cell(cell)
            if cell.digest == state.cell.digest:
                raise CommandRefused("nothing of the cell was changed")
        case UndoCell():
            if not state.before:
                raise CommandRefused("there is no change of the cell to undo")
        case RedoCell():
            if not state.undone:
                raise CommandRefused("there is no change of the cell to redo")
        case EmptyPallets():
            if not state.placed:
                raise CommandRefused("the pallets are empty already")
        case SaveCell(remark=remark):
            _check_text("remark", remark)
            if state.saved == state.cell.digest:
                raise CommandRefused("the cell is saved already")
        case LinkEnded(parts_placed=parts_placed):
            _check_integer("parts_placed", parts_placed, 0, SEED_LIMIT - 1)
        case UseScan() | Stop() | CancelJob() | AcknowledgeFault() | JobEnded() | Sent():
            pass
        case CellRead():
            pass
        case _:
            assert_never(command)


ONE_ARM = frozenset({"abb-socket"})
"""Protocols that cannot say that two arms move at once."""


def can_be_sent(cell: Cell, plan: Plan) -> bool:
    """Whether the controller's protocol can say what the plan does."""
    is_one_by_one = all(len(step.runs) == 1 for step in plan.sequence)
    return is_one_by_one or cell.controller.protocol not in ONE_ARM


def approve(cell: Cell, plan: Plan, proof: Proof, actor: str, now: float) -> Approval:
    """A person's word for exactly this plan, valid as long as the cell's policy says.

    Args:
        cell: the cell as it is now.
        plan: what will be sent.
        proof: of this plan, in this cell.
        actor: the name of the person.
        now: seconds since the epoch.

    Raises:
        CommandRefused: nobody is named, the proof does not hold, or plan, proof and cell do
            not belong together.
    """
    _check_person(actor)
    if digest_of(plan, without=UNSIGNED) != plan.digest:
        raise CommandRefused("the plan was changed after it was made; make a new one")
    if plan.cell_digest != cell.digest:
        raise CommandRefused("the cell has changed since the plan was made; make a new plan")
    if proof.plan_digest != plan.digest:
        raise CommandRefused("the proof is that of another plan; make a new plan")
    if proof.cell_digest != cell.digest or proof.scan_digest != plan.scan_digest:
        raise CommandRefused("the proof was made for another cell or scan; make a new plan")
    if not proof.holds:
        raise CommandRefused(f"the proof does not hold: {proof.findings[0]}")
    if not can_be_sent(cell, plan):
        raise CommandRefused(
            f"the controller's protocol {cell.controller.protocol} moves one arm at a time, "
            "this plan moves both; make an alternated plan to send it"
        )
    return Approval(
        plan_digest=plan.digest,
        proof_digest=proof.digest,
        cell_digest=cell.digest,
        scan_digest=plan.scan_digest,
        actor=actor,
        at=now,
        until=now + cell.policy.approval_minutes * 60.0,
    )


def staleness(
    approval: Approval | None, plan: Plan, cell: Cell, scan_digest: str, now: float
) -> str:
    """Why an approval does not cover this plan, in this cell, for this scan, now.

    Empty when it does.  A clock that was set back to before the approval ends it too.
    """
    if approval is None:
        return "nobody has approved the plan"
    if digest_of(plan, without=UNSIGNED) != plan.digest:
        return "the plan was changed after it was made; make a new one"
    if approval.plan_digest != plan.digest:
        return "the approval is for another plan; have this one approved"
    if approval.cell_digest != cell.digest or plan.cell_digest != cell.digest:
        return "the cell has changed since the approval; make a new plan"
    if approval.scan_digest != scan_digest or plan.scan_digest != scan_digest:
        return "there is a newer scan than that of the approval; make a new plan"
    if not approval.at <= now < approval.until:
        return (
            f"the approval by {approval.actor} was valid for "
            f"{(approval.until - approval.at) / 60:.0f} minutes and has run out; approve again"
        )
    return ""


def _check_actor(command: Command, actor: str) -> None:
    right = RIGHTS[type(command)]
    if right.by_machine and actor not in MACHINES:
        raise CommandRefused(f"{right.says} is reported by a machine, not by {actor!r}")
    if not right.by_machine:
        _check_person(actor)


def _check_person(actor: str) -> None:
    if not actor.strip() or len(actor) > LONGEST_NAME or not actor.isprintable():
        raise CommandRefused(
            f"a person's name is needed, 1 to {LONGEST_NAME} printable characters, not {actor!r}"
        )
    if actor in MACHINES:
        raise CommandRefused(f"{actor!r} is the name of a machine; a person has to ask for this")


def _check_integer(name: str, value: Any, lowest: int, highest: int) -> None:
    if not isinstance(value, int) or isinstance(value, bool) or not lowest <= value <= highest:
        raise CommandRefused(
            f"{name} must be a whole number from {lowest} to {highest}, not {value!r}"
        )


def _check_number(name: str, value: Any, lowest: float, highest: float, unit: str) -> None:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not math.isfinite(value) or not lowest <= value <= highest:
        raise CommandRefused(
            f"{name} must lie between {lowest} and {highest} {unit}, not {value!r}"
        )


def _check_text(name: str, value: Any) -> None:
    if not isinstance(value, str) or len(value) > LONGEST_TEXT or not value.isprintable():
        raise CommandRefused(
            f"{name} must be a text of up to {LONGEST_TEXT} printable characters, not {value!r:.80}"
        )


def _check_among(name: str, value: Any, known: tuple[str, ...]) -> None:
    if value not in known:
        raise CommandRefused(f"{name} {value!r} is not known; there are {', '.join(known)}")


def _check_wishes(cell: Cell, wishes: Wishes) -> None:
    if wishes.planner is not None:
        _check_among("planner", wishes.planner, PLANNER_NAMES)
    if wishes.order is not None:
        _check_among("order", wishes.order, ORDER_NAMES)
    if wishes.iterations is not None:
        _check_integer("iterations", wishes.iterations, 1, MOST_ITERATIONS)
    if wishes.margin is not None:
        _check_number("margin", wishes.margin, cell.policy.margin, LARGEST_MARGIN, "m")
    if wishes.metric is not None:
        _check_number("metric", wishes.metric, 0.05, 1.0, "of the joint before")


def _check_detections(cell: Cell, detections: tuple[Detection, ...]) -> None:
    if not 1 <= len(detections) <= MOST_PARTS:
        raise CommandRefused(f"1 to {MOST_PARTS} poses are needed, not {len(detections)}")
    for number, detection in enumerate(detections, start=1):
        _check_near(f"part-{number}", detection.T_world_part)
        try:
            cell.part(detection.part)
        except InputError as error:
            raise CommandRefused(str(error)) from error


def _check_near(thing: str, T_world_thing: pin.SE3) -> None:
    far = float(np.abs(T_world_thing.translation).max())
    if not far <= FARTHEST:
        raise CommandRefused(f"{thing}: {far:g} m away; {FARTHEST:g} m are allowed")


def _check_cell(cell: Cell) -> None:
    """What a person moves stays in the room, and homes within the limits."""
    _check_near("bin", cell.bin.T_world_bin)
    _check_near("scanner", cell.scanner.T_world_scanner)
    _check_near("robot", cell.T_world_robot)
    for fixture in cell.fixtures:
        _check_near(fixture.name, fixture.T_world_fixture)
    for arm in cell.arms:
        for T in arm.Ts_world_place:
            _check_near(f"a place of the {arm.name} arm", T)
        lower, upper, _ = cell.robot.limits(arm.joints)
        if not np.all((arm.home >= lower) & (arm.home <= upper)):
            raise CommandRefused(f"the home of the {arm.name} arm lies outside its limits")


def _named_plan(state: State, digest: str) -> Plan:
    """The current plan, provided that it is the one meant."""
    if state.plan is None:
        raise CommandRefused("there is no plan; make a plan first")
    if state.plan.digest != digest:
        raise CommandRefused(
            f"the current plan is {state.plan.digest[:12]}, not {digest[:12]}: "
            "look at the current one and decide again"
        )
    return state.plan


def _check_scene(state: State, plan: Plan) -> None:
    if plan.scan_digest != state.scene_digest:
        raise CommandRefused("there is a newer scan than that of the plan; make a new plan")

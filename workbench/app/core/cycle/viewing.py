"""The path of a scanner on an arm to its view, and back: planned like a pick, before any scan."""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.arm_scanner import (
    path_problem,
    path_start,
    standing_joints,
    view_named,
)
from workbench.app.core.state import Phase, ScanState, State, before_a_scan, begin_stage
from workbench.app.core.tasks import Begun, begin_task
from workbench.app.core.value_checks import SEED_LIMIT, check_integer, check_text
from workbench.model.messages.cells import ViewChoiceText
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import all_of
from workbench.model.messages.states import ClearanceText, StateText
from workbench.model.plan import PlanResult, floor_distance
from workbench.model.robot import HOME


@dataclass(frozen=True, slots=True, eq=False)
class PlanView(Command):
    """Plan how the arm with the scanner goes from its home, or another view, to the chosen one.

    `view`: its name, or empty; `HOME`: back from it to the arm's home.
    """

    right: ClassVar[Right] = Right(CommandText.PLAN_VIEW, SAFE)

    view: str = ""
    seed: int = 0

    def check(self, state: State, asked: Asked) -> None:
        check_integer("seed", self.seed, 0, SEED_LIMIT - 1)
        check_text("view", self.view)
        carrier = view_named(state.cell, self.view)
        joints = standing_joints(state.cell, asked.joints)
        refuse(path_problem(state.cell, carrier, joints, self.view))

    def apply(self, state: State, entry: Entry) -> Decision:
        return plan_path(state, entry, view=self.view, seed=self.seed)


def plan_path(state: State, entry: Entry, *, view: str = "", seed: int = 0) -> Begun:
    """The path to the chosen view begins to be planned, or with `HOME` the one back."""
    carrier = view_named(state.cell, view)
    joints = standing_joints(state.cell, entry.joints)
    start = path_start(state.cell, carrier, joints) or HOME
    arguments = {"view": view, "start": start, "placed": state.placed, "seed": seed}
    return begin_task(state, entry, "view", arguments, StateText.PLANNING())


def with_view_plan(state: State, result: PlanResult) -> State:
    """The state after the path to the view, or back, was planned.

    With a plan the scan is void: the arm leaves where it was taken.
    """
    plan, proof, carrier = result.plan, result.proof, state.cell.scanner.on_arm
    if plan is None or proof is None or carrier is None:
        return replace(state, message=StateText.NO_PLAN(verdict=result.verdict.message))
    facts = {
        "cycle": plan.cycle_seconds,
        "clearance": ClearanceText.FREE(free=floor_distance(proof.clearance)),
    }
    message = StateText.VIEW_PLANNED(view=carrier.view.name, **facts)
    if carrier.leads_home(plan.arms[0].legs[0].q):
        message = StateText.HOME_PLANNED(**facts)
    elif state.views_without:
        nothing = ViewChoiceText.NOTHING_FROM(views=state.views_without)
        message = all_of((nothing, message))
    if not proof.holds:
        message = StateText.NOT_PROVEN(violation=proof.violations[0].message)
    return begin_stage(
        before_a_scan(state),
        ScanState,
        phase=Phase.PLANNED,
        scene_digest=plan.scan_digest,
        plan=plan,
        proof=proof,
        verdict=result.verdict,
        seconds=tuple(result.seconds.items()),
        obstacles=result.obstacles,
        message=message,
    )

"""Plans: asked for, compared, and the threshold that a person wants."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

from workbench.app.core.after_a_miss import is_rest_known, with_rest
from workbench.app.core.cell.bins import with_contents
from workbench.app.core.cell.kits import kit_problem, lacks_message
from workbench.app.core.cell.views import next_view_message, with_nothing_seen
from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.arm_scanner import scan_problem, standing_joints
from workbench.app.core.cycle.outcomes import avoided_parts
from workbench.app.core.state import Job, Outline, Phase, PlanState, State, begin_stage
from workbench.app.core.tasks import Begun, begin_task
from workbench.app.core.value_checks import (
    SEED_LIMIT,
    check_among,
    check_integer,
    check_number,
    check_overrides,
)
from workbench.model.candidate import Reason
from workbench.model.cell import Cell, PlanOverrides
from workbench.model.derived.assembling import with_poses_seen
from workbench.model.derived.by_recipe import kit_of, strategies_of, strategy_of, wanted_parts
from workbench.model.derived.row_parts import count_taken
from workbench.model.digest import called
from workbench.model.errors import CommandRefused
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message, all_of
from workbench.model.messages.plans import strategy_message
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import ClearanceText, PosesText, StateText
from workbench.model.motion import floor_distance
from workbench.model.plan import PlanResult, Proven

if TYPE_CHECKING:
    from workbench.app.core.cycle.ahead import GoOn

MOST_OUTLINES = 20
"""Plannings for the same parts that are remembered."""


@dataclass(frozen=True, slots=True, eq=False)
class MakePlan(Command):
    """Judge all candidates, plan and prove.

    `strategy`: one of `strategies_of` the cell; empty: that of the recipe, or `auto`.  `threshold`
    [m]; None: the cell's.  After a missed grip it is for the parts that are left in the same scan.
    """

    right: ClassVar[Right] = Right(
        CommandText.MAKE_PLAN,
        frozenset({Phase.LOCALIZED, Phase.PLANNED, Phase.APPROVED}),
        plans=True,
    )

    strategy: str = "auto"
    threshold: float | None = 0.2
    seed: int = 0
    overrides: PlanOverrides = field(default_factory=PlanOverrides, metadata=called("wishes"))

    @classmethod
    def is_in_phase(cls, state: State) -> bool:
        return state.phase in cls.right.phases or is_rest_known(state)

    @classmethod
    def obstacle(cls, state: State) -> Message | None:
        plan = state.plan
        is_without = plan is not None and not plan.picks and not plan.is_stir_plan
        return Refusal.NO_PARTS() if is_without else None

    def check(self, state: State, asked: Asked) -> None:
        check_planning(state.cell, self)
        joints = standing_joints(state.cell, asked.joints)
        refuse(scan_problem(state.cell, state.scan, joints) or kit_problem(state))

    def apply(self, state: State, entry: Entry) -> Decision:
        return make_plan(with_rest(state) if state.phase is Phase.DONE else state, entry, self)


@dataclass(frozen=True, slots=True, eq=False)
class WantThreshold(Command):
    """A person wants this threshold [m]; while the plan has another one, the plan is stale."""

    right: ClassVar[Right] = Right(CommandText.WANT_THRESHOLD, SAFE, beside_job=True)

    threshold: float

    def check(self, state: State, asked: Asked) -> None:
        check_number("threshold", self.threshold, 0.0, 1.0, "m")

    def apply(self, state: State, entry: Entry) -> Decision:
        return _wanting(state, self.threshold), ()


def check_planning(cell: Cell, command: MakePlan) -> None:
    """What is asked of a planning is possible in this cell.

    Raises:
        CommandRefused: it is not.
    """
    check_integer("seed", command.seed, 0, SEED_LIMIT - 1)
    check_overrides(cell, command.overrides)
    if command.threshold is not None:
        check_number("threshold", command.threshold, 0.0, 1.0, "m")
    if command.strategy:
        check_among("strategy", command.strategy, strategies_of(cell))


def make_plan(state: State, entry: Entry, command: MakePlan, then: "GoOn | None" = None) -> Begun:
    """A plan is made for the parts found; with `then` it is that of a cycle.

    Raises:
        CommandRefused: there are none.
    """
    if not state.detections:
        raise CommandRefused(Refusal.NO_PARTS())
    strategy, threshold = command.strategy or strategy_of(state.cell), command.threshold
    if threshold is None:
        threshold = state.cell.policy.threshold
    arguments: dict[str, Any] = {
        "detections": state.detections,
        "scan_digest": state.scene_digest,
        "scan": state.scan,
        "strategy": strategy,
        "threshold": threshold,
        "overrides": command.overrides,
        "placed": state.placed,
        "avoided": avoided_parts(state, entry.at),
        "wanted": wanted_parts(state.cell, state.kit.counts),
        "seed": command.seed,
    }
    if state.disturbed:
        arguments["disturbed"] = state.disturbed
    state = replace(state, wanted_threshold=threshold)
    about = {
        "strategy": strategy,
        "threshold": threshold,
        "seed": command.seed,
        "planning": command.overrides,
        "then": then,
    }
    return begin_task(state, entry, "plan", arguments, StateText.PLANNING(), **about)


def with_plan(state: State, result: PlanResult, job: Job) -> State:
    """The state after a planning; what was said about an earlier plan goes.

    Args:
        state: before.
        result: what the planning brought; a plan whose proof does not hold is shown, too.
        job: that has ended with it.
    """
    # More time may bring a plan, or a look at what a missed grip has moved.
    is_over = result.plan is None and result.verdict.reason is not Reason.OUT_OF_TIME
    is_over = is_over and not state.disturbed
    state = with_nothing_seen(state) if is_over else state
    # Later paths keep clear of a base where it was seen, also once nothing comes onto it any more.
    state = replace(state, placed=with_poses_seen(state.placed, result.obstacles))
    if result.plan is None:
        phase = Phase.LOCALIZED
        no_plan = StateText.NO_PLAN(verdict=result.verdict.message)
        message = all_of((no_plan, lacks_message(state), next_view_message(state)))
    elif result.proof is None or not result.proof.holds:
        phase = Phase.PLANNED
        message = StateText.NO_PROOF()
        if result.proof is not None:
            message = StateText.NOT_PROVEN(violation=result.proof.violations[0].message)
    else:
        phase = Phase.PLANNED
        state = replace(state, views_without=(), stirs=0)
        message = StateText.PLAN_READY(
            strategy=strategy_message(result.plan.strategy),
            cycle=result.plan.cycle_seconds,
            clearance=ClearanceText.FREE(free=floor_distance(result.proof.clearance)),
        )
        more = StateText.MORE_PLANS(count=len(result.row)) if result.row else None
        remarks = result.plan.remarks if result.plan.stations else ()
        poses = PosesText.UNPROVEN() if state.cell.controller.motion.sends_poses else None
        message = all_of((message, more, *remarks, poses))
    return begin_stage(
        # A kit may lack other kinds later.
        with_contents(state, is_empty=is_over and not kit_of(state.cell)),
        PlanState,
        phase=phase,
        candidates=result.candidates,
        plan=result.plan,
        proof=result.proof,
        verdict=result.verdict,
        seconds=tuple(result.seconds.items()),
        obstacles=result.obstacles,
        bound=result.bound,
        row=result.row,
        row_ends=result.row_ends,
        outlines=_outlines(state, result, job),
        planned_threshold=job.threshold,
        wanted_threshold=state.wanted_threshold,
        message=message,
    )


def _outlines(state: State, result: PlanResult, job: Job) -> tuple[Outline, ...]:
    """All outlines; a plan that was made before keeps its place, by which people know it."""
    found = list(state.outlines)
    for plan_result in (*result.beside, result):
        outline = _outline(plan_result, job)
        places = [k for k, known in enumerate(found) if known.digest == outline.digest != ""]
        if places:
            found[places[0]] = outline
        else:
            found.append(outline)
    return tuple(found[-MOST_OUTLINES:])


def _outline(result: PlanResult, job: Job) -> Outline:
    planning = sum(result.seconds.values())
    plan, proof = result.plan, result.proof
    if plan is None or proof is None:
        return Outline(result.planner, planning, verdict=result.verdict.message)
    every = [Proven(plan, proof), *result.row]
    distances = [
        float(d.min()) for proven_plan in every for _, _, d in proven_plan.proof.apart if len(d)
    ]
    return Outline(
        result.planner,
        planning,
        str(plan.strategy),
        str(plan.guarantee),
        count_taken(result.plans),
        sum(proven_plan.plan.cycle_seconds for proven_plan in every),
        min(proven_plan.proof.clearance for proven_plan in every),
        min(distances, default=None),
        plan.digest,
        None if proof.holds else proof.violations[0].message,
        str(plan.strategy) if job.strategy == "both" else job.strategy,
        job.threshold or 0.0,
        job.seed,
        job.planning,
        len(every),
    )


def _wanting(state: State, threshold: float) -> State:
    """The state with another threshold wanted, also for the plan of a cycle under way."""
    job = state.job
    if job is not None and job.then is not None:
        then = replace(job.then, plan=replace(job.then.plan, threshold=threshold))
        state = replace(state, job=replace(job, then=then))
    return replace(state, wanted_threshold=threshold)

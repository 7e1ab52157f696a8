"""Whether a plan is about this cell and this scene, whole, and within the limits of its joints."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from workbench.model.cell import Arm, Cell, Tool
from workbench.model.geometry import Floats
from workbench.model.messages.message import FoundPart, Message
from workbench.model.messages.plans import (
    guarantee_message,
    leg_message,
    motion_message,
    strategy_message,
)
from workbench.model.messages.proofs import ProofText
from workbench.model.motion import DROP_LEGS, LEG_NAMES, SLOT_LEGS, STIR_LEGS, TOOL_LEGS, VIEW_LEGS
from workbench.model.plan import ArmPlan, Guarantee, Leg, LegName, Plan, Strategy, Violation
from workbench.model.robot import Tcp
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.proof.claims.drop_back import drop_violations
from workbench.proof.claims.scene import unseen_bin
from workbench.proof.claims.stirring import stir_violations
from workbench.proof.claims.tool_change import change_violations

JOINED_WITHIN = 1e-9
"""[rad] Largest distance between the end of a leg and the start of the next.  It is half of the
smallest step that can be sent, for a home that is no whole number of steps."""

HOLDING: frozenset[LegName] = frozenset({"extract", "return", "place", "lift", "carry"})
LINEAR: frozenset[LegName] = frozenset((*SLOT_LEGS, "approach", "extract", "place", "lift"))


def form_violations(cell: Cell, scene: Scene, plan: Plan) -> Iterator[Violation]:
    """What must be right before a plan can be walked through at all."""
    if plan.cell_digest != cell.digest:
        yield Violation(ProofText.OTHER_CELL())
        return
    parts = {part.name for part in cell.parts}
    for detection in (*plan.detections, *scene.detections):
        if detection.part not in parts:
            yield Violation(ProofText.UNKNOWN_PART(part=detection.part))
            return
    yield from _scene(scene, plan)
    if not plan.arms:
        yield Violation(ProofText.NO_ARM())
    names, taken = [arm.arm for arm in plan.arms], [arm.detection for arm in plan.arms]
    if len(set(taken)) != len(taken) or len(set(names)) != len(names):
        yield Violation(ProofText.USED_TWICE())
    known = {arm.name for arm in cell.arms}
    for arm_plan in plan.arms:
        if arm_plan.arm not in known:
            yield Violation(ProofText.UNKNOWN_ARM(name=arm_plan.arm))
        elif not _stated_tcp(cell.arm(arm_plan.arm).tool, arm_plan):
            tool = cell.arm(arm_plan.arm).tool.name
            yield Violation(ProofText.UNKNOWN_TCP(tool=tool, tcp=arm_plan.tcp), arm_plan.arm)
        elif plan.is_tool_plan:
            yield from change_violations(cell, plan, arm_plan)
            yield from _full_bin(cell, plan, arm_plan)
            home = cell.arm(arm_plan.arm).home
            yield from _legs(cell, arm_plan, TOOL_LEGS, (home, home))
        elif plan.is_stir_plan and not arm_plan.takes_part:
            yield from stir_violations(cell, plan, arm_plan)
            home = cell.arm(arm_plan.arm).home
            yield from _legs(cell, arm_plan, STIR_LEGS, (home, home))
        elif plan.is_drop_plan:
            yield from drop_violations(cell, plan, arm_plan)
            start = arm_plan.legs[0].q[0] if arm_plan.legs else np.empty(0)
            names = DROP_LEGS[arm_plan.legs[0].name != "lift" :] if arm_plan.legs else DROP_LEGS
            yield from _legs(cell, arm_plan, names, (start, cell.arm(arm_plan.arm).home))
        elif not arm_plan.takes_part:
            yield from _view(cell, plan, arm_plan)
        elif not 0 <= arm_plan.detection < len(plan.detections):
            yield Violation(ProofText.NO_DETECTION(number=arm_plan.detection), arm_plan.arm)
        else:
            home = cell.arm(arm_plan.arm).home
            yield from _legs(cell, arm_plan, LEG_NAMES, (home, home))
    yield from _sequence(plan)


def at_stated_tcps(cell: Cell, plan: Plan) -> Cell:
    """The cell with each tool at the TCP that a plan states for its arm, which has to have it."""
    tools = {arm.name: arm.tool for arm in cell.arms}
    for arm_plan in plan.arms:
        tcp, tool = _stated_tcp(tools[arm_plan.arm], arm_plan), tools[arm_plan.arm]
        if tcp is not None and tcp.name != tool.tcp:
            at = replace(tool, T_flange_tcp=tcp.T_flange_tcp, tcp=tcp.name)
            tools[arm_plan.arm] = at
    if all(arm.tool is tools[arm.name] for arm in cell.arms):
        return cell
    return replace(cell, arms=tuple(replace(arm, tool=tools[arm.name]) for arm in cell.arms))


def _stated_tcp(tool: Tool, arm_plan: ArmPlan) -> Tcp | None:
    """The TCP that an arm takes its part with, the first one where none is named; None: no such."""
    tcps = tool.tcps or (Tcp("", tool.T_flange_tcp),)
    return next((tcp for tcp in tcps if arm_plan.tcp in ("", tcp.name)), None)


def _scene(scene: Scene, plan: Plan) -> Iterator[Violation]:
    """What the plan says of the bin is what is known of it: nothing else, and nothing left out."""
    if plan.scan_digest != scene.scan_digest:
        yield Violation(ProofText.OTHER_SCAN())
    for number, known in enumerate(scene.detections):
        if not any(_same_part(known, said) for said in plan.detections):
            yield Violation(ProofText.LEFT_OUT(part=FoundPart(number)))
    for number, said in enumerate(plan.detections):
        meant = [known for known in scene.detections if _same_part(said, known)]
        if not meant and said.T_world_found is not None:
            yield Violation(ProofText.NOT_PUT_THERE(part=FoundPart(number)))
        elif not meant:
            yield Violation(ProofText.NOT_IN_SCAN(part=FoundPart(number)))
        elif not any(_no_surer(said, known) for known in meant):
            yield Violation(ProofText.INVENTED_ROLL(part=FoundPart(number)))
    for number, seen in enumerate(scene.obstacles):
        if not any(_same_box(seen, said) for said in plan.obstacles):
            yield Violation(ProofText.OBSTACLE_LEFT_OUT(obstacle=f"seen-{number + 1}"))
    for number, said in enumerate(plan.obstacles):
        if said.part and not any(_same_kept(said, known) for known in scene.obstacles):
            yield Violation(ProofText.INVENTED_PALLET(obstacle=f"seen-{number + 1}"))


def _same_part(detection: Detection, other: Detection) -> bool:
    is_alike = detection.part == other.part
    if detection.T_world_found is not None and other.T_world_found is not None:
        is_alike &= detection.T_world_found.isApprox(other.T_world_found, 1e-9)
    elif detection.T_world_found is not None or other.T_world_found is not None:
        return False
    return is_alike and detection.T_world_part.isApprox(other.T_world_part, 1e-9)


def _no_surer(said: Detection, known: Detection) -> bool:
    """Whether a plan takes the roll of a part for known only where it is."""
    if known.roll_known or said.roll_known:
        return known.roll_known
    axes = [axis for axis in (said.roll_axis, known.roll_axis) if axis is not None]
    return len(axes) == 0 or (len(axes) == 2 and np.allclose(axes[0], axes[1], rtol=0, atol=1e-9))


def _same_box(obstacle: Obstacle, other: Obstacle) -> bool:
    is_alike = np.allclose(obstacle.size, other.size, rtol=0, atol=1e-9)
    return bool(is_alike) and obstacle.T_world_box.isApprox(other.T_world_box, 1e-9)


def _same_kept(obstacle: Obstacle, other: Obstacle) -> bool:
    T, U = obstacle.T_world_put, other.T_world_put
    if T is None or U is None or obstacle.part != other.part or not _same_box(obstacle, other):
        return False
    # A base that was seen is not the same as one that is only believed to stand there, or is gone.
    seen, known = (
        None if box.seen is None else (box.seen.scan, box.seen.problem) for box in (obstacle, other)
    )
    return bool(T.isApprox(U, 1e-9)) and seen == known


def _sequence(plan: Plan) -> Iterator[Violation]:
    runs = [run for step in plan.sequence for run in step.runs]
    names = [arm.arm for arm in plan.arms]
    for arm in plan.arms:
        if [leg for name, leg in runs if name == arm.arm] != [leg.name for leg in arm.legs]:
            yield Violation(ProofText.NOT_EVERY_LEG(), arm.arm)
    if any(name not in names for name, _ in runs):
        yield Violation(ProofText.FOREIGN_ARM())
    for step in plan.sequence:
        arms = [name for name, _ in step.runs]
        if not arms:
            yield Violation(ProofText.EMPTY_STEP())
        if len(set(arms)) != len(arms) or len(arms) > 2:
            yield Violation(ProofText.CROWDED_STEP())
    in_turn = plan.strategy != Strategy.COORDINATED
    is_single = plan.guarantee is Guarantee.ONE_AT_A_TIME
    turns = [arm.arm for arm in plan.arms for _ in arm.legs]
    at_once = [tuple(leg for _, leg in step.runs) for step in plan.sequence if len(step.runs) > 1]
    if (is_single and at_once) or ((is_single or in_turn) and [name for name, _ in runs] != turns):
        yield Violation(ProofText.NOT_IN_TURN())
    alone = plan.strategy.arm
    if (alone and names != [alone]) or (not alone and len(names) != 2):
        strategy = strategy_message(plan.strategy)
        yield Violation(ProofText.OTHER_STRATEGY(strategy=strategy, arms=names))
    if in_turn and not (is_single or at_once):
        guarantee = guarantee_message(plan.guarantee)
        yield Violation(ProofText.NEVER_AT_ONCE(guarantee=guarantee))
    is_in_step = plan.guarantee is Guarantee.SYNCHRONISED
    if in_turn and (is_in_step or any(legs != ("home", "reach") for legs in at_once)):
        yield Violation(ProofText.AT_ONCE(strategy=strategy_message(plan.strategy)))


def _view(cell: Cell, plan: Plan, arm_plan: ArmPlan) -> Iterator[Violation]:
    """The path of a scanner to its view, or back: the only one of its plan, without any part."""
    carrier = cell.scanner.on_arm
    if carrier is None or carrier.arm != arm_plan.arm:
        yield Violation(ProofText.NO_SCANNER(), arm_plan.arm)
        return
    if len(plan.arms) > 1 or plan.detections or arm_plan.grasp or arm_plan.station:
        yield Violation(ProofText.NOT_ONLY_VIEW(), arm_plan.arm)
    yield from _full_bin(cell, plan, arm_plan)
    path = np.asarray(arm_plan.legs[0].q) if arm_plan.legs else np.empty(0)
    ends = carrier.home, carrier.view.q
    if len(path) and path.shape[1:] == carrier.view.q.shape:
        if carrier.leads_home(path):
            ends = carrier.view.q, carrier.home
        else:
            starts = [carrier.home, *(view.q for view in carrier.other_views)]
            ends = min(starts, key=lambda q: np.abs(path[0] - q).max()), carrier.view.q
    yield from _legs(cell, arm_plan, VIEW_LEGS, ends)


def _full_bin(cell: Cell, plan: Plan, arm_plan: ArmPlan) -> Iterator[Violation]:
    """Whether a plan that no scan is for keeps clear of the whole bin."""
    filled = unseen_bin(cell)
    if not any(_same_box(filled, said) for said in plan.obstacles):
        yield Violation(ProofText.BIN_LEFT_OUT(), arm_plan.arm)


def _legs(
    cell: Cell, arm_plan: ArmPlan, names: tuple[LegName, ...], between: tuple[Floats, Floats]
) -> Iterator[Violation]:
    """Whether an arm has the legs of these names, from one posture (n,) [rad, m] to the other."""
    arm = cell.arm(arm_plan.arm)
    if arm_plan.joints != arm.joints:
        yield Violation(ProofText.OTHER_JOINTS(joints=arm.joints), arm.name)
        return
    if tuple(leg.name for leg in arm_plan.legs) != names:
        yield Violation(ProofText.OTHER_LEGS(legs=map(leg_message, names)), arm.name)
        return
    problems = [problem for leg in arm_plan.legs for problem in _shape(arm, leg)]
    yield from problems
    if problems:
        return
    motion, (lower, upper, _) = cell.controller.motion, cell.robot.limits(arm.joints)
    # A home at a limit between two steps cannot be sent: the last step before the limit is home.
    begin, finish = (np.clip(np.asarray(q), *motion.limits(lower, upper)) for q in between)
    ends = [begin, *(leg.q[-1] for leg in arm_plan.legs)]
    starts = [*(leg.q[0] for leg in arm_plan.legs), finish]
    at_home = JOINED_WITHIN + motion.quantum / 2
    off = [at_home, *[JOINED_WITHIN] * (len(names) - 1), at_home]
    for name, end, start, most in zip((*names, names[-1]), ends, starts, off, strict=True):
        if np.abs(end - start).max() > most:
            yield Violation(ProofText.BREAKS(), arm.name, name)


def _shape(arm: Arm, leg: Leg) -> Iterator[Violation]:
    q, t = np.asarray(leg.q), np.asarray(leg.t)
    if q.ndim != 2 or q.shape[1] != len(arm.joints) or t.shape != (len(q),) or len(q) < 2:
        problem = ProofText.SHAPES(waypoints=str(q.shape), times=str(t.shape))
        yield Violation(problem, arm.name, leg.name)
    elif not (np.all(np.isfinite(q)) and np.all(np.isfinite(t)) and np.isfinite(leg.opening)):
        yield Violation(ProofText.NOT_FINITE(), arm.name, leg.name)
    if leg.holding != (leg.name in HOLDING):
        yield Violation(ProofText.WRONG_HOLDING(), arm.name, leg.name)
    if (leg.motion == "linear") != (leg.name in LINEAR):
        yield Violation(
            ProofText.WRONG_MOTION(motion=motion_message(leg.motion)), arm.name, leg.name
        )


def joint_limit_violations(cell: Cell, arm: Arm, leg: Leg) -> Iterator[Violation]:
    """Joints beyond their limits on one leg.

    A joint between two waypoints is between its values there, so waypoints are enough.
    """
    lower, upper, _ = cell.robot.limits(arm.joints)
    q = np.asarray(leg.q)
    outside = np.argwhere((q < lower - 1e-9) | (q > upper + 1e-9))
    if len(outside):
        row, joint = outside[0].tolist()
        low, high = float(lower[joint]), float(upper[joint])
        problem = ProofText.JOINT_LIMIT(
            joint=arm.joints[joint], at=float(q[row, joint]), low=low, high=high
        )
        yield Violation(problem, arm.name, leg.name, row)


def opening_and_time_violations(cell: Cell, arm: Arm, leg: Leg) -> Iterator[Violation]:
    """Openings beyond the stroke, waypoints that the controller cannot represent, wrong times.

    Speeds and accelerations are asked by `timing.pace_violations`.
    """

    def violation(problem: Message) -> Violation:
        return Violation(problem, arm.name, leg.name)

    if not cell.controller.motion.is_sendable(np.asarray(leg.q)):
        yield violation(ProofText.TOO_FINE())
    low, high = arm.tool.stroke
    if arm.tool.fingers and not low <= leg.opening <= high:
        yield violation(ProofText.STROKE(opening=leg.opening))
    if leg.t[0] != 0.0:
        yield violation(ProofText.LATE_START())
    if np.any(np.diff(leg.t) <= 0):
        yield violation(ProofText.TIMES())

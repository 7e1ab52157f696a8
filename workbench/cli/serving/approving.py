"""A plan approved at a terminal: its facts, the robot at its start, and a person's vote."""

import sys
import threading
from collections.abc import Mapping, Sequence

from workbench.app.core.cycle.standing import moved_away
from workbench.app.records.approvals import SHORTEST
from workbench.model.candidate import label_grasp
from workbench.model.cell import Cell
from workbench.model.derived.row_parts import label_in, parts_taken
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, LinkError, ProtocolError
from workbench.model.messages.message import FoundPart
from workbench.model.motion import at_least
from workbench.model.plan import Plan, Proof, Proven
from workbench.model.tools.held_body import HeldAmount
from workbench.plugins.robot_link import states
from workbench.proof.claims.clearance import linear_clearance
from workbench.proof.claims.drop_back import drop_point, fall_height

REPORTS = 2.0
"""[s] A controller that reports its joints does so within."""


def row_digest(plans: Sequence[Plan]) -> str:
    """What a person repeats who lets plans out: the digest of the plan, or that of their row."""
    digests = [plan.digest for plan in plans]
    return digests[0] if len(digests) == 1 else digest_of(tuple(digests))


def row_facts(cell: Cell, plans: Sequence[Proven], basis: str, start: str) -> dict[str, str]:
    """What a person has to read before plans in a row are approved; see `facts_of`."""
    first = plans[0]
    facts = facts_of(cell, first.plan, first.proof, basis, start)
    if len(plans) == 1:
        return facts
    row = row_digest([plan.plan for plan in plans])
    facts = {"Row": f"{row}: {len(plans)} plans by one approval", **facts}
    for number, plan in enumerate(plans[1:], 2):
        basis = f"by what is left of plan {number - 1}"
        more = facts_of(cell, plan.plan, plan.proof, basis, "", first.plan)
        for name in ("Cell", "Robot", "Controller", "Preview"):
            del more[name]
        facts |= {f"{number}. {name}": value for name, value in more.items()}
    return facts


def facts_of(
    cell: Cell, plan: Plan, proof: Proof, basis: str, start: str, first: Plan | None = None
) -> dict[str, str]:
    """What a person has to read before a plan is approved, by name.

    Args:
        cell: with the controller that it goes to.
        plan: the plan.
        proof: of it.
        basis: what the proof knew of the bin.
        start: whether the robot stands where the plan starts.
        first: plan of its row, as in which parts are called; None: the plan itself.
    """
    first = first or plan
    facts = {"Plan": plan.digest, "Cell": f"{cell.name} {cell.digest[:SHORTEST]}"}
    for part, arm in zip(parts_taken(first, plan), plan.picks, strict=True):
        kind = plan.detections[arm.detection].part
        takes = f"{FoundPart(part)} ({kind}), grasp {label_grasp(arm.grasp, arm.tcp)}"
        facts[f"Arm {arm.arm}"] = takes + (f", to station {arm.station}" if arm.station else "")
    kept = sum(bool(obstacle.part) for obstacle in plan.obstacles)
    known = f"{len(plan.detections)} parts, {len(plan.obstacles) - kept} unknown things: {basis}"
    if plan.is_view_plan and (carrier := cell.scanner.on_arm) is not None:
        leads_home = carrier.leads_home(plan.arms[0].legs[0].q)
        goal = "home" if leads_home else f"to view {carrier.view.name}"
        facts[f"Arm {carrier.arm}"] = f"takes the scanner {goal}"
        known = "counts as full, since no scan shows it yet"
    if plan.is_stir_plan:
        stirs, opening = "stirs what lies in the bin", plan.arms[0].leg("stir").opening
        open_by = f"fingers {opening * 1000:.1f} mm open"
        with_what = open_by if cell.arm(plan.strategy.arm).tool.fingers else "its hand"
        facts[f"Arm {plan.strategy.arm}"] = f"{stirs} with {with_what}"
    if plan.is_drop_plan:
        held = HeldAmount(plan.arms[0].held)
        height, p = fall_height(cell, held), drop_point(cell, held) * 1000
        place = f"at {p[0]:.0f}, {p[1]:.0f}, {p[2]:.0f} mm; how far it falls is not known"
        where = place if height is None else f"from {height * 1000:.0f} mm at most"
        facts[f"Arm {plan.strategy.arm}"] = f"drops back what it holds ({held}) {where}"
        known = "counts as full, since no scan counts"
    if plan.is_tool_plan:
        changes = f"puts down {cell.arm(plan.strategy.arm).tool.name}, takes {plan.arms[0].tool}"
        facts[f"Arm {plan.strategy.arm}"] = changes
        known = "counts as full, since no scan counts"
    nearest, link = proof.nearest, cell.controller
    holds = f"holds, {proof.digest[:SHORTEST]}"
    if link.motion.sends_poses:
        holds += "; only of the plan: nothing of the robot's own motion is proven"
    near, linear = at_least(proof.clearance), linear_clearance(proof)
    if nearest is not None and nearest.pair is not None:
        near += f", arm {nearest.arm}, leg {nearest.leg} after waypoint {nearest.waypoint}"
        near += ": " + " and ".join(label_in(body, first, plan.detections) for body in nearest.pair)
    return facts | {
        "Strategy": f"{plan.strategy.words}, {plan.guarantee}",
        "Motion": f"{plan.cycle_seconds:.1f} s, up to {cell.policy.speed:.0%} of joint speeds",
        "Minimum clearance": near,
        **({} if linear is None else {"On linear motion": at_least(max(linear, 0.0))}),
        "Proof": holds,
        "Bin": known,
        **({"Pallets": f"by the plan's word alone {kept} parts lie there: look"} if kept else {}),
        "Robot": start,
        "Controller": f"{link.host} port {link.port}, {link.link}",
        "Preview": "not played: nobody has watched this plan",
    }


def start_words(cell: Cell, plan: Plan) -> str:
    """Whether the robot stands where a plan starts, by the report of its controller.

    Raises:
        CommandRefused: it stands elsewhere.
    """
    if cell.controller.motion.sends_poses:
        return "moves by its own program, from wherever it stands"
    joints = reported_joints(cell)
    if not joints:
        return "reports no joints: see for yourself that it stands where the plan starts"
    if problem := moved_away(cell, plan, joints):
        raise CommandRefused(problem)
    return "stands where the plan starts"


def reported_joints(cell: Cell) -> Mapping[str, float]:
    """Joints by name [rad or m] as the controller reports them; empty where it reports none.

    Raises:
        CommandRefused: what it reports makes no sense.
    """
    ended = threading.Event()
    timer = threading.Timer(REPORTS, ended.set)
    timer.start()
    try:
        for report in states(cell, ended.is_set):
            reported = report.joints
            reports = [(arm, reported[arm.name]) for arm in cell.arms if arm.name in reported]
            return {j: v for arm, q in reports for j, v in zip(arm.joints, q, strict=True)}
    except ProtocolError as error:
        raise CommandRefused(f"what is reported of the robot makes no sense: {error}") from error
    except LinkError:
        return {}
    finally:
        timer.cancel()
    return {}


def typed_digest(actor: str) -> str:
    """What a person types who has read the facts.

    Raises:
        CommandRefused: no person is there.
    """
    if not sys.stdin.isatty():
        raise CommandRefused(
            "nobody has approved the plan, as this is no terminal: read what is printed, and "
            f"repeat the command with --digest and the first {SHORTEST} characters of the plan's"
        )
    print(
        f"Type the first {SHORTEST} characters of the plan's digest to approve it as {actor}: ",
        end="",
        file=sys.stderr,
        flush=True,
    )
    return sys.stdin.readline().strip()


def check_digest(plans: Sequence[Plan], given: str) -> None:
    """Refuse a digest that is not that of the plan or row, or too short to tell it from others.

    Raises:
        CommandRefused: nothing is approved.
    """
    if len(given) < SHORTEST or not row_digest(plans).startswith(given):
        what = "plan" if len(plans) == 1 else "row of plans"
        raise CommandRefused(
            f"{given[:64]!r} is not the digest of this {what}; nothing was approved and nothing "
            "sent"
        )

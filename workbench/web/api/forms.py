"""Values as JSON for programs: SI units and radians, poses as rows of 4 x 4 matrices."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

from workbench.app.core.cell.kits import lacks_of
from workbench.app.core.cycle.rows import plans_sent
from workbench.app.core.state import State, sent_for
from workbench.app.emptying.summary import summary
from workbench.app.emptying.what_if import rank_changes
from workbench.app.review.commissioning import CheckedStep
from workbench.app.runtime.live import Live
from workbench.app.statistics.statistics import GROUPS, Statistics
from workbench.model.candidate import Candidate, Verdict
from workbench.model.derived.by_recipe import kit_of, strategies_of
from workbench.model.derived.by_view import view_name, views_of
from workbench.model.derived.row_parts import parts_taken
from workbench.model.digest import canonical
from workbench.model.messages.message import as_message
from workbench.model.plan import Proof, Violation
from workbench.model.prediction import Emptying
from workbench.model.recipes.seen_base import SeenBase
from workbench.model.scan import Scan

Form = dict[str, Any]

SCAN_SECONDS = 1.0
"""[s] As the study has it where nobody says otherwise."""


def state_form(state: State, live: Live) -> Form:
    """What everybody may know at a glance; the large values have answers of their own."""
    sent = sent_for(state)
    return {
        "number": state.number,
        "phase": str(state.phase),
        "message": str(state.message),
        "said": as_message(state.message).program_form,
        "fault": str(state.fault),
        "stale": "" if state.stale is None else str(state.stale),
        "ran": None if state.ran is None else state.ran.digest,
        "changed": list(map(str, state.changed)),
        "cell": state.cell.name,
        "cell_digest": state.cell.digest,
        "bin": state.cell.bin.name,
        "bins": [box.name for box in state.cell.bins],
        "empty_bins": [box.name for box in state.cell.bins if box.name in state.empty_bins],
        "view": view_name(state.cell),
        "views": [view.name for view in views_of(state.cell)],
        "recipe": state.cell.recipe,
        "recipes": [{"number": r.number, "name": r.name} for r in state.cell.recipes],
        "kit": _kit_form(state),
        "is_saved": state.is_saved,
        "control": state.control,
        "asking": list(state.asking),
        "job": None if state.job is None else state.job.number,
        "getting_ready": _preparing(live),
        "scan": None if state.scan is None else state.scan.digest,
        "detections": None if state.detections is None else len(state.detections),
        "wrong_parts": list(live.wrong_parts(state.detections)),
        "wrong_sizes": list(map(str, live.wrong_sizes(state.detections))),
        "verdict": None if state.verdict is None else verdict_form(state.verdict),
        "plan": None if state.plan is None else state.plan.digest,
        "strategy": None if state.plan is None else str(state.plan.strategy),
        "strategies": list(strategies_of(state.cell)),
        "holds": None if state.proof is None else state.proof.holds,
        "row": [_row_form(state, number) for number in range(len(state.whole_row))],
        "row_ends": "" if state.row_ends is None else str(state.row_ends),
        "row_ends_said": None if state.row_ends is None else state.row_ends.program_form,
        "row_left_out": len(state.left_out),
        "watched": list(state.watched),
        "approved_by": [] if state.approval is None else list(state.approval.people),
        "approved_unwatched": state.approval is not None and state.approval.is_unwatched,
        "approved_until": None if state.approval is None else state.approval.until,
        "approved_speed": None if state.approval is None else state.approval.speed_share,
        "approved_stepped": state.approval is not None and state.approval.is_stepped,
        "step_waits": state.waits,
        "ahead": None if state.ahead is None else [job.name for job, _, _ in state.ahead.brought],
        "messages_sent": len(state.receipts),
        "parts_placed": state.parts_placed,
        "outcomes": [
            {
                "detection": outcome.detection,
                "is_picked": outcome.is_picked,
                "by": outcome.by,
                "why": str(outcome.why),
                "result": str(outcome.became),
            }
            for outcome in (() if sent is None else sent.outcomes)
        ],
    }


def _kit_form(state: State) -> Form | None:
    """What belongs in a kit and what it has, and how many were taken away before it."""
    counts = state.kit.counts
    items = [
        {"part": item.part, "count": item.count, "has": counts.get(item.part, 0)}
        for item in kit_of(state.cell)
    ]
    if not items:
        return None
    is_complete = not lacks_of(state)
    return {
        "items": items,
        "is_complete": is_complete,
        "complete_before": state.kit.complete,
        "incomplete_before": state.kit.incomplete,
        "bases": [
            _base_form(box.part, box.seen) for box in state.obstacles if box.seen is not None
        ],
    }


def _base_form(part: str, seen: SeenBase) -> Form:
    """Where a scan shows a part that stands in the assembly; no pose where it does not."""
    T = seen.T_world_part
    return {
        "part": part,
        "scan": seen.scan,
        "T_world_part": None if T is None else T.homogeneous.tolist(),
        "shift": seen.shift,
        "turn": seen.turn,
        "said": seen.message(part).program_form,
    }


def _row_form(state: State, number: int) -> Form:
    """One plan of the row; `parts` are indices in the first one, as people number them."""
    proven_plan = state.whole_row[number]
    return {
        "plan": proven_plan.plan.digest,
        "proof": proven_plan.proof.digest,
        "holds": proven_plan.proof.holds,
        "clearance": finite(proven_plan.proof.clearance),
        "cycle_seconds": proven_plan.plan.cycle_seconds,
        "parts": list(parts_taken(state.plans[0], proven_plan.plan)),
        "is_sent": number < plans_sent(state),
    }


def job_form(state: State, live: Live) -> Form:
    """The running task, or none; `message` says how the last one ended."""
    job = state.job
    return {
        "number": state.number,
        "phase": str(state.phase),
        "message": str(state.message),
        "said": as_message(state.message).program_form,
        "job": None
        if job is None
        else {
            "number": job.number,
            "name": job.name,
            "at": job.at,
            "done": finite(live.progress_of(job.number)[0]),
            "note": str(live.progress_of(job.number)[1]),
        },
        "getting_ready": _preparing(live),
    }


def _preparing(live: Live) -> Form | None:
    what = live.getting_ready
    return None if what is None else {"done": finite(what.done), "note": str(what.note)}


def scan_form(scan: Scan) -> Form:
    """A scan without its points."""
    low, high = scan.points_world.min(axis=0), scan.points_world.max(axis=0)
    return {
        "digest": scan.digest,
        "source": scan.source,
        "at": scan.at,
        "points": len(scan.points),
        "resolution": None if scan.resolution is None else list(scan.resolution),
        "T_world_scanner": canonical(scan.T_world_scanner),
        "low": low.tolist(),
        "high": high.tolist(),
        "views": [
            {
                "name": view.name,
                "points": view.count,
                "T_world_scanner": canonical(view.T_world_scanner),
                "shift": view.shift,
                "turn": view.turn,
                "looked_through": view.through,
                "is_off": view.is_off,
            }
            for view in scan.views
        ],
    }


def candidate_form(candidate: Candidate) -> Form:
    """A candidate with its verdict."""
    return {
        "detection": candidate.detection,
        "grasp": candidate.grasp.name,
        "arm": candidate.arm,
        "tcp": candidate.tcp,
        "rank": finite(candidate.rank),
        "T_world_tcp": canonical(candidate.T_world_tcp),
        "verdict": verdict_form(candidate.verdict),
    }


def verdict_form(verdict: Verdict) -> Form:
    """A verdict with its evidence."""
    return {
        "reason": verdict.reason.name,
        "stage": str(verdict.stage),
        "pair": None if verdict.pair is None else list(verdict.pair),
        "distance": None if verdict.distance is None else finite(verdict.distance),
        "q": None if verdict.q is None else verdict.q.tolist(),
        "note": "" if verdict.note is None else str(verdict.note),
        "said": verdict.message.program_form,
    }


def proof_form(proof: Proof) -> Form:
    """A proof without the clearance of every waypoint."""
    return {
        "digest": proof.digest,
        "plan": proof.plan_digest,
        "holds": proof.holds,
        "checks": proof.checks,
        "resolution": finite(proof.resolution),
        "clearance": finite(proof.clearance),
        "nearest": None if proof.nearest is None else _place_form(proof.nearest),
        "violations": [_place_form(violation) for violation in proof.violations],
        "speeds": [
            {
                "arm": fast.arm,
                "leg": fast.leg,
                "tcp": finite(fast.tcp),
                "point": finite(fast.point),
                "mass": fast.mass,
                "energy": fast.energy,
            }
            for fast in proof.speeds
        ],
    }


def emptying_form(found: Emptying) -> Form:
    """Piles emptied in simulation, as the study of emptying prints them.

    Of the parts an hour a scan takes `SCAN_SECONDS`, and a person no time.
    """
    takes = {"scan_seconds": SCAN_SECONDS, "approval_seconds": 0.0}
    is_tried = len(found.plain) < len(found.piles)
    return {
        "cell_digest": found.cell_digest,
        **summary(found.plain, **takes),
        "what_if": rank_changes(found.piles, **takes) if is_tried else [],
    }


def statistics_form(statistics: Statistics) -> Form:
    """How often picks have succeeded, and what was in the way."""
    return {
        "cycles": len(statistics.cycles),
        "picked": statistics.picked,
        "picks_per_hour": statistics.picks_per_hour,
        "rates": {name: _rates(statistics, name) for name in GROUPS},
        "refusals": {reason: count for reason, count in statistics.refusals},
        "kits": [
            {"recipe": kit.recipe, "complete": kit.complete, "incomplete": kit.incomplete}
            for kit in statistics.kits
        ],
        "stages": {
            stage: {"median": middle, "largest": largest}
            for stage, middle, largest in statistics.stage_medians()
        },
    }


def commissioning_form(checked: Iterable[CheckedStep]) -> list[Form]:
    """Each step, whether it is done, and what was verified or is missing."""
    return [
        {
            "step": str(each.step),
            "is_done": each.is_done,
            "text": str(each.says),
            "said": each.says.program_form,
        }
        for each in checked
    ]


def finite(value: float) -> float | None:
    """A number as JSON can say it; None where it cannot."""
    return float(value) if math.isfinite(value) else None


def _rates(statistics: Statistics, name: str) -> Mapping[str, Form]:
    return {rate.name: dict(rate.counts) for rate in statistics.rates(GROUPS[name])}


def _place_form(place: Violation) -> Form:
    return {
        "problem": str(place.problem),
        "said": place.message.program_form,
        "arm": place.arm,
        "leg": place.leg,
        "waypoint": place.waypoint,
        "pair": None if place.pair is None else list(place.pair),
        "distance": None if place.distance is None else finite(place.distance),
    }

"""Whether what went to the robot is what was approved: by whom, in which row, speed and steps.

`verify.py` carries it along, so it imports nothing but Python's own.
"""

import hashlib
import json
from collections.abc import Iterable, Iterator
from typing import Any

LATE = 1.5
"""[ms] Times are whole milliseconds on the wire."""


START_ENTRIES = {"Opened", "Started"}
"""Kinds of entries after which no approval counts that was given before."""


def approval_problems(entries: Iterable[tuple[int, str, Any]]) -> Iterator[str]:
    """A sending goes by the newest approval, of that plan, that holds then; each serves once.

    Of a row the plans follow one another by what that approval says of them.  `entries`: number,
    kind, body.
    """
    given = sent = None
    for number, kind, said in entries:
        if kind in START_ENTRIES:
            given = sent = None
        elif kind == "Approve":
            given = said.get("approval")
        elif kind == "LinkEnded":
            if goes_on(said):
                if problem := row_problem(sent, said):
                    yield f"entry {number} {problem}"
                sent = said.get("approval")
            else:
                sent = None
        elif kind == "SendPlan":
            approval = said.get("approval")
            if not isinstance(approval, dict):
                yield f"entry {number} sends a plan without an approval"
            elif approval.get("plan_digest") != said.get("command", {}).get("plan_digest"):
                yield f"entry {number} sends another plan than the one approved"
            elif not approval.get("at", 0) <= said.get("at", 0) < approval.get("until", 0):
                yield f"entry {number} sends a plan when its approval did not hold"
            elif approval != given:
                yield f"entry {number} sends by an approval not given before it, or used"
            given, sent = None, approval


def step_problems(entries: Iterable[tuple[int, str, Any]]) -> Iterator[str]:
    """Steps that ran without a person's word, and times that are not the approved share's.

    `entries`: number, kind, body.
    """
    plan: Any = None
    approval: Any = {}
    let: Any = 0
    last_step = place = 0
    times: list[float] = []
    for number, kind, body in entries:
        command: Any = _fields(body.get("command"))
        if kind == "JobEnded":
            plan = _fields(command.get("result")).get("plan") or plan
        elif kind == "SendPlan" or (kind == "LinkEnded" and goes_on(body)):
            # Of a row each plan goes out with its own times, and is stepped from its first step.
            row = row_plans(plan)
            place = 0 if kind == "SendPlan" else place + 1
            approval, let, last_step = _fields(body.get("approval")), 0, 0
            now = row[place] if place < len(row) else None
            times = _compute_waypoint_times(now, approval.get("speed_share", 1.0))
        elif kind == "NextStep":
            if not approval.get("is_stepped") or command.get("number") != let + 1:
                yield f"entry {number} lets a step run that was not to run then"
            let = command.get("number")
        elif kind == "Sent" and command["receipt"]["kind"] in ("next", "to", "ticket"):
            words = str(command["receipt"]["sent"]).split()
            if len(words) < 3:
                yield f"entry {number} is no message to a robot"
            elif words[1] == "next":
                if int(words[2]) != last_step + 1 or int(words[2]) > let:
                    yield f"entry {number} tells the robot to run a step that nobody has let run"
                last_step = int(words[2])
            elif words[1] == "ticket":
                if (words[5:] == ["stepped"]) != bool(approval.get("is_stepped")):
                    yield f"entry {number} is another manner of sending than the one approved"
            elif times and abs(int(words[-1]) - times.pop(0)) > LATE:
                yield f"entry {number} has not the time of the plan at the approved speed"


def goes_on(body: Any) -> bool:
    """Whether the next plan of a row follows the end of a sending."""
    return _fields(_fields(body).get("after")).get("phase") == "sending"


def row_plans(result: Any) -> list[Any]:
    """The plan that a planning has brought, and those after it."""
    fields = _fields(result)
    after = fields.get("row")
    others = (
        [_fields(proven_plan).get("plan") for proven_plan in after]
        if isinstance(after, list)
        else []
    )
    return [fields.get("plan"), *others]


def row_problem(given: Any, body: Any) -> str:
    """Why the next plan of a row has not gone out by what was given; empty when it has.

    `given`: the approval by which the plan before went out; `body`: of the entry that ended that.
    """
    before, approval = _fields(given), _fields(_fields(body).get("approval"))
    row = before.get("row") or []
    said = (approval.get("plan_digest"), approval.get("proof_digest"))
    if not row or said != tuple(row[0]) or (approval.get("row") or []) != row[1:]:
        return "lets another plan follow than the one approved"
    if approval.get("first") != (before.get("first") or digest_of(before)):
        return "lets a plan follow by another approval than the one given"
    changed = {"plan_digest", "proof_digest", "row", "first"}
    if any(approval.get(key) != before.get(key) for key in {*before, *approval} - changed):
        return "lets a plan follow by an approval that was changed"
    if not approval.get("at", 0) <= _fields(body).get("at", 0) < approval.get("until", 0):
        return "lets a plan follow when its approval did not hold"
    after = _fields(_fields(body).get("after"))
    if (after.get("plan"), after.get("proof")) != said:
        return "lets another plan follow than the one approved"
    command = _fields(_fields(body).get("command"))
    parts = [_fields(part).get("is_picked") for part in command.get("parts") or ()]
    if command.get("fault") or not parts or any(part is not True for part in parts):
        return "lets a plan follow after one that did not end well"
    return ""


def digest_of(value: Any) -> str:
    """The digest of a value in canonical form."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _fields(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _compute_waypoint_times(plan: Any, share: float) -> list[float]:
    """From waypoint to waypoint [ms], in the order in which they are reported."""
    if not isinstance(plan, dict):
        return []
    legs = {(arm["arm"], leg["name"]): leg["t"] for arm in plan["arms"] for leg in arm["legs"]}
    ways = [legs[arm, name] for step in plan["sequence"] for arm, name in step["runs"]]
    return [1000 * (t[k] - t[k - 1]) / share for t in ways for k in range(1, len(t))]

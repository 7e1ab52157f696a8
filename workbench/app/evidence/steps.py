"""Whether what went to the robot is what was approved in speed and steps.

`verify.py` carries it along, so it imports nothing that `verify.py` does not.
"""

from collections.abc import Iterable, Iterator
from typing import Any

LATE = 1.5
"""[ms] Times are whole milliseconds on the wire."""


def step_problems(entries: Iterable[tuple[int, str, Any]]) -> Iterator[str]:
    """Steps that ran without a person's word, and times that are not the approved share's.

    `entries`: number, kind, body.
    """
    plan: Any = None
    approval: Any = {}
    let: Any = 0
    told = 0
    times: list[float] = []
    for number, kind, body in entries:
        command: Any = _fields(body.get("command"))
        if kind == "JobEnded":
            plan = _fields(command.get("result")).get("plan") or plan
        elif kind == "SendPlan":
            approval, let, told = _fields(body.get("approval")), 0, 0
            times = _told_times(_fields(plan).get("plan"), approval.get("speed_share", 1.0))
        elif kind == "NextStep":
            if not approval.get("is_stepped") or command.get("number") != let + 1:
                yield f"entry {number} lets a step run that was not to run then"
            let = command.get("number")
        elif kind == "Sent" and command["receipt"]["kind"] in ("next", "to", "ticket"):
            words = str(command["receipt"]["sent"]).split()
            if len(words) < 3:
                yield f"entry {number} is no message to a robot"
            elif words[1] == "next":
                if int(words[2]) != told + 1 or int(words[2]) > let:
                    yield f"entry {number} tells the robot to run a step that nobody has let run"
                told = int(words[2])
            elif words[1] == "ticket":
                if (words[5:] == ["stepped"]) != bool(approval.get("is_stepped")):
                    yield f"entry {number} is another manner of sending than the one approved"
            elif times and abs(int(words[-1]) - times.pop(0)) > LATE:
                yield f"entry {number} has not the time of the plan at the approved speed"


def _fields(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _told_times(plan: Any, share: float) -> list[float]:
    """From waypoint to waypoint [ms], in the order in which they are told."""
    if not isinstance(plan, dict):
        return []
    legs = {(arm["arm"], leg["name"]): leg["t"] for arm in plan["arms"] for leg in arm["legs"]}
    ways = [legs[arm, name] for step in plan["sequence"] for arm, name in step["runs"]]
    return [1000 * (t[k] - t[k - 1]) / share for t in ways for k in range(1, len(t))]

"""The states of a controller that speaks `abb-socket/2`: one table for all who keep to it.

The simulated controller looks the next state up here, the RAPID module carries the same rows, and
`docs/protocol.md` shows them; tests compare the three.
"""

from collections.abc import Mapping
from typing import Literal, get_args

ControllerPhase = Literal[
    "greeted", "ready", "loading", "loaded", "running", "waiting", "fault", "stopped"
]

PHASES = frozenset(get_args(ControllerPhase))

NEXT: Mapping[tuple[ControllerPhase, str], ControllerPhase] = {
    ("greeted", "hello"): "ready",
    ("ready", "plan"): "loading",
    ("loading", "ticket"): "loading",
    ("loading", "start"): "loading",
    ("loading", "load"): "loading",
    ("loading", "axes"): "loading",
    ("loading", "leg"): "loading",
    ("loading", "to"): "loading",
    ("loading", "end"): "loaded",
    ("loaded", "run"): "running",
    ("running", "done"): "ready",
    ("running", "fault"): "fault",
    ("running", "wait"): "waiting",
    ("waiting", "next"): "running",
    ("waiting", "fault"): "fault",
    ("ready", "ping"): "ready",
    ("loading", "ping"): "loading",
    ("loaded", "ping"): "loaded",
    ("running", "ping"): "running",
    ("waiting", "ping"): "waiting",
    ("fault", "ping"): "fault",
    ("ready", "abort"): "stopped",
    ("loading", "abort"): "stopped",
    ("loaded", "abort"): "stopped",
    ("running", "abort"): "stopped",
    ("waiting", "abort"): "stopped",
    ("fault", "abort"): "stopped",
}
"""State and what comes, to the state after it.

`done`, `fault` and `wait` come from the robot, all else from the workbench.  What has no row is
refused, the robot stops if it moves, and the link is closed.
"""

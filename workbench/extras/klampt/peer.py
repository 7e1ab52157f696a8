"""Plans with Klamp't, in a process of its own: `python -m workbench.extras.klampt.peer`.

Reads one JSON object from standard input and writes one JSON object a line to standard output,
one for each goal and planner.  Klamp't (extra `bench`) is imported nowhere else.

Request: `world` (file); `margin` [m] to everything that stands still, `planners`, `start` and
`goals` (whole configurations as Klamp't orders them), `moving` (indices of the joints that move);
`seconds` a plan may take.
"""

import json
import sys
import time
from collections.abc import Mapping
from typing import Any

BATCH = 10
"""Iterations between two looks at the clock."""

OPTIONS: Mapping[str, Mapping[str, Any]] = {
    "rrt": {"type": "rrt", "perturbationRadius": 0.5},
    "birrt": {"type": "rrt", "perturbationRadius": 0.5, "bidirectional": 1},
    "sbl": {"type": "sbl", "perturbationRadius": 0.5, "randomizeFrequency": 1000},
}
"""By the thesis' names; SBL as in Klamp't's own examples, the others with the same radius."""


def main() -> None:
    """Entry point."""
    request = json.load(sys.stdin)
    from klampt import WorldModel
    from klampt.plan import robotplanning

    world = WorldModel()
    if not world.readFile(request["world"]):
        sys.exit(f"Klamp't cannot read {request['world']}")
    robot = world.robot(0)
    for number in range(world.numTerrains()):
        world.terrain(number).geometry().setCollisionMargin(request["margin"])
    for planner in request["planners"]:
        for number, goal in enumerate(request["goals"]):
            robot.setConfig(request["start"])
            began, used = time.perf_counter(), time.process_time()
            plan = robotplanning.plan_to_config(
                world, robot, goal, movingSubset=request["moving"], **OPTIONS[planner]
            )
            path, iterations = None, 0
            while plan is not None and time.perf_counter() - began < request["seconds"]:
                plan.planMore(BATCH)
                iterations += BATCH
                path = plan.getPath()
                if path:
                    break
            taken, used = time.perf_counter() - began, time.process_time() - used
            if plan is not None:
                plan.space.close()
                plan.close()
            answer = {
                "planner": planner,
                "goal": number,
                "is_possible": plan is not None,
                "seconds": taken,
                "processor": used,
                "iterations": iterations,
                "path": path or None,
            }
            print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()

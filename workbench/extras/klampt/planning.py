"""The same scene, start and goals given to Klamp't, the library that the thesis planned with."""

import contextlib
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from workbench.extras.klampt.urdf_writer import depth_first
from workbench.extras.klampt.worlds import Snapshot, robot_with_tools, write_world
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.planning.collision.world import World
from workbench.plugins.extras import install_command
from workbench.plugins.progress import Report, silent
from workbench.studies.motion import solving
from workbench.studies.motion.problems import ARM, Case
from workbench.studies.planners import Attempt, Course

KLAMPT_PLANNERS = ("rrt", "birrt", "sbl")


@dataclass(frozen=True, slots=True, eq=False)
class KlamptPath:
    """What one planner of Klamp't found to the `goal`-th goal: a path (m, n) [rad], or None.

    `seconds` of the clock and `processor` [s] are those of its search.
    """

    planner: str
    goal: int
    is_possible: bool
    seconds: float
    processor: float
    path: Floats | None


def attempts_by_klampt(
    course: Course,
    *,
    seconds: float,
    report: Report,
    planners: Sequence[str] = KLAMPT_PLANNERS,
) -> list[Attempt]:
    """Plan from the course's start to all its goals with Klamp't.

    Args:
        course: robot, bin and goals; Klamp't sees the same collision geometry and margins.
        seconds: that a plan may take.
        report: progress.
        planners: among `KLAMPT_PLANNERS`.

    Raises:
        InputError: Klamp't is not installed, or ends before it is done.
    """
    goals = course.goals
    ends = [q for _, q in goals]
    found = paths_by_klampt(
        course.world,
        course.arm.joints,
        course.start,
        ends,
        planners,
        seconds=seconds,
        report=report,
    )
    return [
        Attempt(
            f"Klamp't {klampt_path.planner}",
            goals[klampt_path.goal][0],
            None,
            None,
            klampt_path.seconds,
            0.0,
            None if klampt_path.path is None else course.tool_way(klampt_path.path),
        )
        for klampt_path in found
    ]


def solve_by_klampt(
    cases: Sequence[Case], *, seconds: float, report: Report
) -> list[solving.Attempt]:
    """Every case that is not invalid by Klamp't's SBL, each in a process of its own.

    What it finds is as its search leaves it: neither shortened nor rounded.  Where it sees an end
    touch something it has no path.

    Args:
        cases: made by `cases_of`.
        seconds: [s] that a plan may take.
        report: progress.

    Raises:
        InputError: Klamp't is not installed, or ends before it is done.
    """
    valid = [case for case in cases if not case.invalid]
    attempts: list[solving.Attempt] = []
    for number, case in enumerate(valid):
        report(number / len(valid), f"Klamp't, {case.name}")
        joints, goals = case.world.arm(ARM).joints, [case.goal]
        (path,) = paths_by_klampt(
            case.world, joints, case.start, goals, ["sbl"], seconds=seconds, report=silent
        )
        attempts.append(
            solving.Attempt(
                solving.KLAMPT,
                case.name,
                case.robot,
                case.number,
                path.seconds,
                path.processor,
                path.path,
            )
        )
    return attempts


def paths_by_klampt(
    world: World,
    joints: Sequence[str],
    start: Floats,
    goals: Sequence[Floats],
    planners: Sequence[str],
    *,
    seconds: float,
    report: Report,
) -> list[KlamptPath]:
    """Plan from one configuration to others with Klamp't.

    Args:
        world: robot, bin and fixtures; Klamp't sees the same collision geometry and margin.
        joints: those that move.
        start: their values (n,) [rad].
        goals: (n,) [rad] each.
        planners: among `KLAMPT_PLANNERS`.
        seconds: that a plan may take.
        report: progress.

    Raises:
        InputError: Klamp't is not installed, or ends before it is done.
    """
    names = [joint.name for joint in depth_first(robot_with_tools(world.cell, Snapshot()))]
    moving = [names.index(joint) for joint in joints]

    def whole(q: Floats) -> list[float]:
        values = np.zeros(len(names))
        values[moving] = q
        return values.tolist()

    with tempfile.TemporaryDirectory() as folder:
        file = write_world(Path(folder), "course", world.cell, Snapshot())
        request = {
            "world": str(file),
            "margin": world.policy.margin,
            "planners": list(planners),
            "start": whole(start),
            "goals": [whole(q) for q in goals],
            "moving": moving,
            "seconds": seconds,
        }
        answers = _ask(request, len(planners) * len(goals), report)
    return [
        KlamptPath(
            answer["planner"],
            answer["goal"],
            answer["is_possible"],
            answer["seconds"],
            answer["processor"],
            None if answer["path"] is None else np.array(answer["path"])[:, moving],
        )
        for answer in answers
    ]


def _ask(request: dict[str, Any], count: int, report: Report) -> list[dict[str, Any]]:
    """The answers of the peer process, which is ended whatever happens here."""
    # What it complains of goes to a file: a pipe that nobody empties would hold it up.
    with (
        tempfile.TemporaryFile("w+") as complaints,
        subprocess.Popen(
            [sys.executable, "-m", "workbench.extras.klampt.peer"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=complaints,
            text=True,
        ) as process,
    ):
        try:
            assert process.stdin is not None and process.stdout is not None
            # When it has ended already, its complaint says more than the broken pipe.
            with contextlib.suppress(BrokenPipeError):
                process.stdin.write(json.dumps(request))
            with contextlib.suppress(BrokenPipeError):
                process.stdin.close()
            answers: list[dict[str, Any]] = []
            for line in process.stdout:
                if line.startswith("{"):  # Klamp't itself talks on standard output, too
                    answers.append(json.loads(line))
                    report(len(answers) / count, f"Klamp't {answers[-1]['planner']}")
            if process.wait() != 0 or len(answers) != count:
                complaints.seek(0)
                raise InputError(f"Klamp't did not finish: {_reason(complaints.read())}")
        finally:
            process.kill()
    return answers


def _reason(text: str) -> str:
    if "No module named 'klampt'" in text:
        return f"it is not installed; {install_command('bench')}"
    return text.strip().splitlines()[-1] if text.strip() else "it ended without a word"

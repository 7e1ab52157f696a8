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

from workbench.app.picking.pipeline import Report
from workbench.formats.klampt.worlds import Snapshot, robot_with_tools, write_world
from workbench.formats.robots.urdf_writer import depth_first
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.studies.planners import Course

KLAMPT_PLANNERS = ("rrt", "birrt", "sbl")


@dataclass(frozen=True, slots=True, eq=False)
class KlamptAttempt:
    """One planner of Klamp't at one goal; `is_possible` is False when it refuses an end."""

    planner: str
    target: int
    is_possible: bool
    seconds: float
    tool_way: float | None


def attempts_by_klampt(
    course: Course, planners: Sequence[str], *, seconds: float, report: Report
) -> list[KlamptAttempt]:
    """Plan from the course's start to all its goals with Klamp't.

    Args:
        course: robot, bin and goals; Klamp't sees the same collision geometry and margins.
        planners: among `KLAMPT_PLANNERS`.
        seconds: that a plan may take.
        report: progress.

    Raises:
        InputError: Klamp't is not installed, or ends before it is done.
    """
    names = [joint.name for joint in depth_first(robot_with_tools(course.world.cell, Snapshot()))]
    moving = [names.index(joint) for joint in course.arm.joints]

    def whole(q: Floats) -> list[float]:
        values = np.zeros(len(names))
        values[moving] = q
        return values.tolist()

    goals = course.goals
    with tempfile.TemporaryDirectory() as folder:
        world = write_world(Path(folder), "course", course.world.cell, Snapshot())
        request = {
            "world": str(world),
            "margin": course.world.policy.margin,
            "planners": list(planners),
            "start": whole(course.start),
            "goals": [whole(q) for _, q in goals],
            "moving": moving,
            "seconds": seconds,
        }
        answers = _asked(request, len(planners) * len(goals), report)
    return [_attempt(course, moving, goals[answer["goal"]][0], answer) for answer in answers]


def _asked(request: dict[str, Any], count: int, report: Report) -> list[dict[str, Any]]:
    """The answers of the peer process, which is ended whatever happens here."""
    # What it complains of goes to a file: a pipe that nobody empties would hold it up.
    with (
        tempfile.TemporaryFile("w+") as complaints,
        subprocess.Popen(
            [sys.executable, "-m", "workbench.studies.klampt_peer"],
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


def _reason(told: str) -> str:
    if "No module named 'klampt'" in told:
        return "it is not installed; pip install 'workbench[bench]'"
    return told.strip().splitlines()[-1] if told.strip() else "it ended without a word"


def _attempt(
    course: Course, moving: list[int], target: int, answer: dict[str, Any]
) -> KlamptAttempt:
    path = None if answer["path"] is None else np.array(answer["path"])[:, moving]
    return KlamptAttempt(
        answer["planner"],
        target,
        answer["is_possible"],
        answer["seconds"],
        None if path is None else course.tool_way(path),
    )


def summary(attempts: Sequence[KlamptAttempt]) -> list[dict[str, Any]]:
    """One row a planner, with the keys of `planners.summary`; times in s."""
    groups: dict[str, list[KlamptAttempt]] = {}
    for one in attempts:
        groups.setdefault(one.planner, []).append(one)
    return [_row(planner, group) for planner, group in groups.items()]


def _row(planner: str, group: Sequence[KlamptAttempt]) -> dict[str, Any]:
    seconds = np.array([one.seconds for one in group])
    ways = [one.tool_way for one in group if one.tool_way is not None]
    return {
        "planner": f"Klamp't {planner}",
        "allowed": None,
        "attempts": len(group),
        "success": len(ways) / len(group),
        "search_mean": float(seconds.mean()),
        "mean": float(seconds.mean()),
        "median": float(np.median(seconds)),
        "p95": float(np.percentile(seconds, 95)),
        "iterations_mean": None,
        "tool_way_mean": float(np.mean(ways)) if ways else None,
    }

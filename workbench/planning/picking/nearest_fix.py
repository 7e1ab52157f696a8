"""What would have to change for a refused grasp to work: found by trying, smallest change first."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from workbench.model.candidate import Candidate, Pick, Stage
from workbench.model.cell import Cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Grasp
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.tool_check import ToolCheck
from workbench.planning.collision.world import World
from workbench.planning.picking.propose import candidate_of
from workbench.planning.picking.resolve import resolve

TURNS = tuple(range(5, 50, 5))
"""[degrees] about the approach axis, both ways."""

BACK_OFFS = tuple(range(1, 11))
"""[mm] by which the hand may take the part less deep."""

SLIDES = (2, 4, 6, 8, 10)
"""[mm] along the fingers' opening and across it, both ways."""

MOST_REFUSED = 8
"""Candidates that are looked at, the best ones first."""


@dataclass(frozen=True, slots=True, eq=False)
class Fix:
    """A change, in words, that admits a refused candidate; it was tried up to the place."""

    candidate: Candidate
    change: str


def nearest_fix(
    cell: Cell,
    detections: tuple[Detection, ...],
    candidates: tuple[Candidate, ...],
    *,
    seed: int,
    obstacles: tuple[Obstacle, ...] = (),
) -> Fix | None:
    """The smallest change that was found to admit a refused candidate, the best one if possible.

    The best is the one that got furthest along the line, then that which lacks least distance;
    the next ones are looked at when nothing admits it.

    Args:
        cell: that the candidates were judged in.
        detections: the parts found.
        candidates: all of them, judged.
        seed: of the request.
        obstacles: what the scan shows beside the parts.

    Returns:
        None when no change of those tried admits any of the `MOST_REFUSED` best.
    """
    refused = [one for one in candidates if not one.verdict.is_ok and one.verdict.pair is not None]
    refused.sort(key=_progress, reverse=True)
    admits, as_tight = _trial(cell, detections, obstacles, seed), None
    margin = cell.policy.near_margin
    for best in refused[:MOST_REFUSED]:
        for change, grasp in _changes(best.grasp):
            if admits(best, grasp):
                return Fix(best, change)
        if margin > 0:
            policy = replace(cell.policy, near_margin=0.0)
            as_tight = as_tight or _trial(replace(cell, policy=policy), detections, obstacles, seed)
            if as_tight(best, best.grasp):
                return Fix(
                    best, f"keep less than near_margin, {margin * 1000:g} mm, on straight legs"
                )
    return None


def _trial(
    cell: Cell, detections: tuple[Detection, ...], obstacles: tuple[Obstacle, ...], seed: int
) -> Callable[[Candidate, Grasp], bool]:
    """Whether another grasp in the place of a candidate's works up to the place."""
    check = ToolCheck(cell, detections, obstacles)
    world = World(cell, detections, obstacles)

    def admits(refused: Candidate, grasp: Grasp) -> bool:
        arm, number = cell.arm(refused.arm), refused.detection
        tried = candidate_of(cell, check, detections, number, grasp, arm)
        return tried.verdict.is_ok and isinstance(resolve(world, tried, seed=seed), Pick)

    return admits


def _progress(candidate: Candidate) -> tuple[int, float]:
    verdict = candidate.verdict
    return list(Stage).index(verdict.stage), verdict.distance or 0.0


def _changes(grasp: Grasp) -> Iterator[tuple[str, Grasp]]:
    """Changed grasps with the change in words, in the order of its size against its range."""
    found: list[tuple[float, str, Grasp]] = []

    def add(size: float, words: str, xyz: tuple[float, float, float], yaw: float = 0.0) -> None:
        T = grasp.T_part_tcp * pose_from_rpy(xyz, (0.0, 0.0, np.deg2rad(yaw)))
        found.append((size, words, replace(grasp, T_part_tcp=T)))

    for turn in TURNS:
        for sign in (1, -1):
            words = f"turn the grasp about its approach axis by {sign * turn} degrees"
            add(turn / TURNS[-1], words, (0.0, 0.0, 0.0), sign * turn)
    for back in BACK_OFFS:
        add(back / BACK_OFFS[-1], f"take it {back} mm less deep", (0.0, 0.0, -back / 1000))
    for slide in SLIDES:
        for sign in (1, -1):
            way = sign * slide / 1000
            size = slide / SLIDES[-1]
            add(size, f"move it {sign * slide} mm along x of the TCP", (way, 0.0, 0.0))
            add(size, f"move it {sign * slide} mm along y of the TCP", (0.0, way, 0.0))
    for _, words, changed in sorted(found, key=lambda entry: entry[0]):
        yield words, changed

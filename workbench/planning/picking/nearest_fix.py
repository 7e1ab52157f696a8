"""What would have to change for a refused grasp to work: found by trying, smallest change first."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Candidate, Pick, Reason, Stage
from workbench.model.cell import LIFT_NAMES, Cell, Policy, Tool
from workbench.model.derived.by_tcp import by_taking
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.grasps import FixText
from workbench.model.messages.message import FoundPart, Message
from workbench.model.part import Grasp
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import chain_of
from workbench.planning.kinematics.inverse import configurations, starts_of
from workbench.planning.picking.propose import candidate_of
from workbench.planning.picking.resolve import resolve

TURNS_TRIED: tuple[float, ...] = tuple(np.deg2rad(range(5, 50, 5)).tolist())
"""[rad] Turns of the hand about the approach axis, in both directions."""

BACK_OFFS = tuple(k / 1000 for k in range(1, 11))
"""[m] Distances by which the hand grasps less deep."""

SLIDES = (0.002, 0.004, 0.006, 0.008, 0.010)
"""[m] Shifts along the fingers' opening and across it, in both directions."""

OPENINGS = (0.002, 0.004, 0.006, 0.008, 0.010, 0.012)
"""[m] Changes of the fingers' opening on arrival, in both directions."""

BIN_MOVES = (0.02, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.4)
"""[m] Shifts of the bin with its content along one axis."""

ROLL_CHANGE = FixText.ROLL()
"""The change that admits a grasp for the poses found, but not for every roll of the part."""

LEAST_AIR = 0.001
"""[m] Minimum gap between each finger and the part."""

MOST_REFUSED = 8
"""Candidates for which changes are tried, the best of them first."""


@dataclass(frozen=True, slots=True, eq=False)
class Fix:
    """A change that may admit a refused candidate.

    `change` is the message about it.  `grasp` or `policy` is the changed one; neither for
    `ROLL_CHANGE` and a moved bin, which only a person can make.
    """

    candidate: Candidate
    change: Message
    grasp: Grasp | None = None
    policy: Policy | None = None


def fix_words(fix: Fix | None) -> Message:
    """The message about a fix: for which candidate, and what was tried."""
    if fix is None:
        return FixText.NONE(
            turn=_degrees(TURNS_TRIED[-1]),
            back=_millimetres(BACK_OFFS[-1]),
            slide=_millimetres(SLIDES[-1]),
            opening=_millimetres(OPENINGS[-1]),
        )
    candidate = fix.candidate
    return FixText.NEAREST(
        arm=candidate.arm,
        part=FoundPart(candidate.detection),
        grasp=candidate.grasp.name,
        change=fix.change,
    )


def nearest_fix(
    cell: Cell,
    detections: tuple[Detection, ...],
    candidates: tuple[Candidate, ...],
    *,
    seed: int,
    obstacles: tuple[Obstacle, ...] = (),
    may_move_bin: bool = True,
) -> Fix | None:
    """The smallest change that admits a refused candidate, tried up to the place.

    Candidates are tried in the order of their progress, then of the distance that they lack.

    Args:
        cell: that the candidates were judged in.
        detections: the parts found.
        candidates: all of them, judged.
        seed: of the request.
        obstacles: other objects in the scan.
        may_move_bin: where no grasp helps and some are out of reach, bin or base may be moved.

    Returns:
        None when no change of those tried admits any of the `MOST_REFUSED` best.
    """
    refused = [
        candidate
        for candidate in candidates
        if not candidate.verdict.is_ok and candidate.verdict.pair is not None
    ]
    refused.sort(key=lambda candidate: candidate.verdict.progress, reverse=True)
    fixes = Fixes(cell, detections, obstacles, seed=seed)
    for best in refused[:MOST_REFUSED]:
        for fix in fixes.of(best):
            if fixes.admits(fix):
                return fix
    if not may_move_bin:
        return None
    far = [candidate for candidate in candidates if candidate.verdict.reason is Reason.OUT_OF_REACH]
    far.sort(key=lambda candidate: candidate.verdict.distance or np.inf)
    return _move_bin(cell, detections, far[:MOST_REFUSED], obstacles, seed)


def _move_bin(
    cell: Cell,
    detections: tuple[Detection, ...],
    far: list[Candidate],
    obstacles: tuple[Obstacle, ...],
    seed: int,
) -> Fix | None:
    """The least move of the bin that admits one of these candidates, which are out of reach."""
    chains = {arm.name: chain_of(cell, arm) for arm in cell.arms}
    starts = {arm.name: starts_of(chains[arm.name], arm, seed) for arm in cell.arms}
    for distance, axis, sign in product(BIN_MOVES, "xyz", (1, -1)):
        shift = pin.SE3(np.eye(3), sign * distance * np.eye(3)["xyz".index(axis)])
        reached = [
            candidate
            for candidate in far
            if len(
                configurations(
                    chains[candidate.arm], shift * candidate.T_world_tcp, starts[candidate.arm]
                ).q
            )
        ]
        if not reached:
            continue
        world = World(
            replace(cell, bin=replace(cell.bin, T_world_bin=shift * cell.bin.T_world_bin)),
            tuple(replace(part, T_world_part=shift * part.T_world_part) for part in detections),
            tuple(replace(box, T_world_box=shift * box.T_world_box) for box in obstacles),
        )
        for candidate in reached:
            if _is_feasible(world, candidate, candidate.grasp, seed):
                by = _millimetres(sign * distance)
                change = FixText.MOVE_BIN(by=f"{by:+d}", axis=axis, back=f"{-by:+d}")
                return Fix(candidate, change)
    return None


class Fixes:
    """The changes that may admit refused candidates, tried one by one.

    Lifetime: as long as cell and detections.
    """

    def __init__(
        self,
        cell: Cell,
        detections: tuple[Detection, ...],
        obstacles: tuple[Obstacle, ...] = (),
        *,
        seed: int,
    ) -> None:
        self._cell = cell
        self._detections = detections
        self._obstacles = obstacles
        self._seed = seed
        self._worlds: dict[tuple[Message | None, str], World] = {}

    def of(self, candidate: Candidate) -> list[Fix]:
        """The changes for a candidate, smallest first; other lifts first if its lift is blocked."""
        policy, tool = self._cell.policy, self._cell.arm(candidate.arm).tool
        grasps = [
            Fix(candidate, change, grasp=grasp)
            for change, grasp in _grasp_changes(candidate.grasp, tool)
        ]
        lifts: list[Fix] = []
        if set(policy.lifts) != set(LIFT_NAMES):
            change = FixText.LIFTS(lifts=LIFT_NAMES)
            lifts.append(Fix(candidate, change, policy=replace(policy, lifts=LIFT_NAMES)))
        others: list[Fix] = []
        if policy.near_margin > 0:
            change = FixText.NEAR_MARGIN(margin=policy.near_margin)
            others.append(Fix(candidate, change, policy=replace(policy, near_margin=0.0)))
        if not all(detection.roll_known for detection in self._detections):
            others.append(Fix(candidate, ROLL_CHANGE))
        is_lift_blocked = candidate.verdict.stage is Stage.EXTRACT
        return [*lifts, *grasps, *others] if is_lift_blocked else [*grasps, *lifts, *others]

    def admits(self, fix: Fix) -> bool:
        """Whether the candidate of a change, one of those of `of`, is feasible with it."""
        candidate = fix.candidate
        # All changes of a grasp share one world, and so do equal changes of different candidates.
        key = None if fix.grasp else fix.change, candidate.tcp
        if key not in self._worlds:
            cell = self._cell if fix.policy is None else replace(self._cell, policy=fix.policy)
            detections = self._detections
            if fix.change == ROLL_CHANGE:
                detections = tuple(
                    replace(detection, roll_known=True, roll_axis=None) for detection in detections
                )
            self._worlds[key] = World(by_taking(cell, candidate), detections, self._obstacles)
        grasp = fix.grasp or candidate.grasp
        return _is_feasible(self._worlds[key], candidate, grasp, self._seed)


def _is_feasible(world: World, refused: Candidate, grasp: Grasp, seed: int) -> bool:
    """Whether a grasp instead of that of a candidate is feasible up to the place."""
    tried = candidate_of(world, refused.detection, grasp, world.arm(refused.arm))
    return tried.verdict.is_ok and isinstance(resolve(world, tried, seed=seed), Pick)


def _grasp_changes(grasp: Grasp, tool: Tool) -> list[tuple[Message, Grasp]]:
    """Changed grasps with their messages, in the order of the change relative to its range."""
    found: list[tuple[float, Message, Grasp]] = []

    def add(share: float, change: Message, xyz: tuple[float, float, float], yaw: float) -> None:
        T = grasp.T_part_tcp * pose_from_rpy(xyz, (0.0, 0.0, yaw))
        found.append((share, change, replace(grasp, T_part_tcp=T)))

    for k, turn in enumerate(TURNS_TRIED, 1):
        for yaw in (turn, -turn):
            add(k / len(TURNS_TRIED), FixText.TURN(angle=_degrees(yaw)), (0.0, 0.0, 0.0), yaw)
    for k, back in enumerate(BACK_OFFS, 1):
        add(k / len(BACK_OFFS), FixText.LESS_DEEP(by=back), (0.0, 0.0, -back), 0.0)
    for k, slide in enumerate(SLIDES, 1):
        for by in (slide, -slide):
            share, shown = k / len(SLIDES), _millimetres(by)
            add(share, FixText.SLIDE(by=shown, axis="x"), (by, 0.0, 0.0), 0.0)
            add(share, FixText.SLIDE(by=shown, axis="y"), (0.0, by, 0.0), 0.0)
    low, high = tool.stroke
    for k, step in enumerate(OPENINGS if tool.fingers else (), 1):
        for opening in (grasp.opening - step, grasp.opening + step):
            if max(grasp.grip + 2 * LEAST_AIR, low) <= opening <= high:
                change = FixText.OPENING(opening=opening)
                found.append((k / len(OPENINGS), change, replace(grasp, opening=opening)))
    return [(change, changed) for _, change, changed in sorted(found, key=lambda entry: entry[0])]


def _degrees(angle: float) -> int:
    return round(np.rad2deg(angle))


def _millimetres(length: float) -> int:
    return round(length * 1000)

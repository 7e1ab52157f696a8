"""What would have to change for a refused grasp to work: found by trying, smallest change first."""

from collections.abc import Callable, Iterator
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

TURNS_TRIED = tuple(range(5, 50, 5))
"""[degrees] about the approach axis, both ways."""

BACK_OFFS = tuple(range(1, 11))
"""[mm] by which the hand may take the part less deep."""

SLIDES = (2, 4, 6, 8, 10)
"""[mm] along the fingers' opening and across it, both ways."""

OPENINGS = (2, 4, 6, 8, 10, 12)
"""[mm] by which the fingers may arrive less or more open."""

MOVES = (20, 40, 60, 80, 100, 150, 200, 300, 400)
"""[mm] by which the bin, with all that lies in it, may lie elsewhere along one axis."""

ROLL_CHANGE = FixText.ROLL()
"""The change that admits what works for parts as they were found, but not for every roll."""

LEAST_AIR = 0.001
"""[m] That is left between each finger and the part, at least."""

MOST_REFUSED = 8
"""Candidates that are checked, the best ones first."""


@dataclass(frozen=True, slots=True, eq=False)
class Fix:
    """A change that admits a refused candidate; it was tried up to the place.

    `change` is the message about it.  `grasp` or `policy` is the changed one; neither for
    `ROLL_CHANGE`, which nothing here can make.
    """

    candidate: Candidate
    change: Message
    grasp: Grasp | None = None
    policy: Policy | None = None


def fix_words(fix: Fix | None) -> Message:
    """A fix as the command line and the page say it: for which candidate, and what was tried."""
    if fix is None:
        return FixText.NONE(
            turn=TURNS_TRIED[-1], back=BACK_OFFS[-1], slide=SLIDES[-1], opening=OPENINGS[-1]
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
    """The smallest change that was found to admit a refused candidate, the best one if possible.

    The best is the one that got furthest along the line, then that which lacks least distance;
    the next ones are checked when nothing admits it.

    Args:
        cell: that the candidates were judged in.
        detections: the parts found.
        candidates: all of them, judged.
        seed: of the request.
        obstacles: what the scan shows beside the parts.
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
        for change in fixes.of(best):
            if fixes.admits(best, change):
                return fixes.fix(best, change)
    if not may_move_bin:
        return None
    far = [candidate for candidate in candidates if candidate.verdict.reason is Reason.OUT_OF_REACH]
    far.sort(key=lambda candidate: candidate.verdict.distance or np.inf)
    return _moved_bin(cell, detections, far[:MOST_REFUSED], obstacles, seed)


def _moved_bin(
    cell: Cell,
    detections: tuple[Detection, ...],
    far: list[Candidate],
    obstacles: tuple[Obstacle, ...],
    seed: int,
) -> Fix | None:
    """The least move of the bin after which one of these, now out of reach, works."""
    chains = {arm.name: chain_of(cell, arm) for arm in cell.arms}
    starts = {arm.name: starts_of(chains[arm.name], arm, seed) for arm in cell.arms}
    for way in MOVES:
        for axis, sign in product("xyz", (1, -1)):
            shift = pin.SE3(np.eye(3), sign * way / 1000 * np.eye(3)["xyz".index(axis)])
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
            admits = _trial(
                replace(cell, bin=replace(cell.bin, T_world_bin=shift * cell.bin.T_world_bin)),
                tuple(
                    replace(detection, T_world_part=shift * detection.T_world_part)
                    for detection in detections
                ),
                tuple(
                    replace(obstacle, T_world_box=shift * obstacle.T_world_box)
                    for obstacle in obstacles
                ),
                seed,
            )
            for candidate in reached:
                if admits(candidate, candidate.grasp):
                    by, back = f"{sign * way:+d}", f"{-sign * way:+d}"
                    change = FixText.MOVE_BIN(by=by, axis=axis, back=back)
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
        self._given = (detections, obstacles, seed)
        self._of: Candidate | None = None
        self._changed: dict[Message, Grasp] = {}
        self._trials: dict[tuple[Message | None, str], Callable[[Candidate, Grasp], bool]] = {}
        policy = cell.policy
        self._policies: dict[Message, Policy] = {}
        self._rolls: dict[Message, tuple[Detection, ...]] = {}
        if not all(detection.roll_known for detection in detections):
            self._rolls[ROLL_CHANGE] = tuple(
                replace(detection, roll_known=True, roll_axis=None) for detection in detections
            )
        self._of_lifts: list[Message] = []
        if set(policy.lifts) != set(LIFT_NAMES):
            words = FixText.LIFTS(lifts=LIFT_NAMES)
            self._policies[words] = replace(policy, lifts=LIFT_NAMES)
            self._of_lifts.append(words)
        if policy.near_margin > 0:
            words = FixText.NEAR_MARGIN(margin=policy.near_margin)
            self._policies[words] = replace(policy, near_margin=0.0)

    def of(self, candidate: Candidate) -> list[Message]:
        """The changes in words, the smallest first; other lifts first where that is blocked."""
        first = self._of_lifts if candidate.verdict.stage is Stage.EXTRACT else []
        rest = (words for words in self._policies if words not in first)
        return [*first, *self._grasps(candidate), *rest, *self._rolls]

    def _grasps(self, candidate: Candidate) -> dict[Message, Grasp]:
        if self._of is not candidate:
            tool = self._cell.arm(candidate.arm).tool
            self._of, self._changed = candidate, dict(_changes(candidate.grasp, tool))
        return self._changed

    def fix(self, candidate: Candidate, change: Message) -> Fix:
        """A change in words, of those for a candidate, with what it makes of grasp or policy."""
        policy = self._policies.get(change)
        grasp = self._grasps(candidate).get(change)
        return Fix(candidate, change, grasp, policy)

    def admits(self, candidate: Candidate, change: Message) -> bool:
        """Whether a candidate works with a change, up to the place."""
        grasp, policy = candidate.grasp, self._policies.get(change)
        detections, obstacles, seed = self._given
        detections = self._rolls.get(change, detections)
        is_of_all = policy is not None or change in self._rolls
        if not is_of_all:
            grasp = self._grasps(candidate)[change]
        key = change if is_of_all else None, candidate.tcp
        if key not in self._trials:
            cell = self._cell if policy is None else replace(self._cell, policy=policy)
            cell = by_taking(cell, candidate)
            self._trials[key] = _trial(cell, detections, obstacles, seed)
        return self._trials[key](candidate, grasp)


def _trial(
    cell: Cell, detections: tuple[Detection, ...], obstacles: tuple[Obstacle, ...], seed: int
) -> Callable[[Candidate, Grasp], bool]:
    """Whether another grasp in the place of a candidate's works up to the place."""
    world = World(cell, detections, obstacles)

    def admits(refused: Candidate, grasp: Grasp) -> bool:
        arm, number = cell.arm(refused.arm), refused.detection
        tried = candidate_of(world, number, grasp, arm)
        return tried.verdict.is_ok and isinstance(resolve(world, tried, seed=seed), Pick)

    return admits


def _changes(grasp: Grasp, tool: Tool) -> Iterator[tuple[Message, Grasp]]:
    """Changed grasps with the change in words, in the order of its size against its range."""
    found: list[tuple[float, Message, Grasp]] = []

    def add(size: float, words: Message, xyz: tuple[float, float, float], yaw: float = 0.0) -> None:
        T = grasp.T_part_tcp * pose_from_rpy(xyz, (0.0, 0.0, np.deg2rad(yaw)))
        found.append((size, words, replace(grasp, T_part_tcp=T)))

    for turn in TURNS_TRIED:
        for sign in (1, -1):
            words = FixText.TURN(angle=sign * turn)
            add(turn / TURNS_TRIED[-1], words, (0.0, 0.0, 0.0), sign * turn)
    for back in BACK_OFFS:
        add(back / BACK_OFFS[-1], FixText.LESS_DEEP(by=back / 1000), (0.0, 0.0, -back / 1000))
    for slide in SLIDES:
        for sign in (1, -1):
            way = sign * slide / 1000
            size = slide / SLIDES[-1]
            add(size, FixText.SLIDE(by=sign * slide, axis="x"), (way, 0.0, 0.0))
            add(size, FixText.SLIDE(by=sign * slide, axis="y"), (0.0, way, 0.0))
    low, high = tool.stroke
    for step in OPENINGS if tool.fingers else ():
        for sign in (-1, 1):
            wide = grasp.opening + sign * step / 1000
            if max(grasp.grip + 2 * LEAST_AIR, low) <= wide <= high:
                words = FixText.OPENING(opening=wide)
                found.append((step / OPENINGS[-1], words, replace(grasp, opening=wide)))
    for _, words, changed in sorted(found, key=lambda entry: entry[0]):
        yield words, changed

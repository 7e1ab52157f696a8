"""Candidates at a glance: how they would be judged where something is dragged, while it is.

As far as is quick enough for ten answers a second: the hand where the part lies, as planning judges
it first (`propose`), whether the arm gets its hand there, and with the part to one of its places.
What is refused here planning refuses, too; the ways there and back are left to it.
"""

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
import pinocchio as pin

from workbench.app.picking.pipeline import NOTHING, levels_of, without_avoided
from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Bools, Floats, Ints, put
from workbench.model.part import with_symmetry
from workbench.model.scan import Obstacle
from workbench.planning.collision.hands import turns_of
from workbench.planning.collision.legs import grips, hand_turns
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import Chain, is_solution
from workbench.planning.picking.propose import propose
from workbench.planning.picking.put_down import ways_at_places
from workbench.planning.picking.resolve import starts_of

T = TypeVar("T")

Change = Mapping[str, Any]
"""What is otherwise in a cell: fields of `Cell`, and as `libraries` grasp libraries by part."""


@dataclass(frozen=True, slots=True, eq=False)
class Glance:
    """All candidates of some parts found, each a row: little to send, and enough to draw.

    `detections` (n,) are numbers of parts, `reasons` (n,) what is said, `is_apart` (n,) whether the
    bodies that are too close do not touch; `tips` (n, 3) [m] and `approaches` (n, 3), unit vectors,
    where the hand would be in the world and how it comes.  `obstacles` were kept clear of.
    """

    detections: Ints
    reasons: tuple[Reason, ...]
    is_apart: Bools
    tips: Floats
    approaches: Floats
    obstacles: tuple[Obstacle, ...] = ()

    @property
    def working(self) -> Bools:
        """Which candidates nothing speaks against, booleans (n,)."""
        return np.array([reason is Reason.OK for reason in self.reasons], dtype=bool)


def changed(cell: Cell, change: Change) -> Cell:
    """A cell with that change, to be looked at and thrown away: it keeps the digest of the other.

    A digest takes as long as the look.  What stays is the same object, so what is kept for it
    serves.
    """
    rest = dict(change)
    libraries = rest.pop("libraries", {})
    parts = tuple(
        _otherwise(
            part,
            library=libraries[part.name],
            grasps=with_symmetry(libraries[part.name], part.symmetry),
        )
        if part.name in libraries
        else part
        for part in cell.parts
    )
    return _otherwise(cell, **rest, parts=parts)


def _otherwise(value: T, **others: Any) -> T:
    """A copy of a frozen value with other fields, made without what is worked out of them."""
    made = copy(value)
    put(made, **others)
    return made


def glance_of(candidates: tuple[Candidate, ...], obstacles: tuple[Obstacle, ...] = ()) -> Glance:
    """The same candidates, in short."""
    distances = [one.verdict.distance for one in candidates]
    tips = [one.T_world_tcp.translation for one in candidates]
    ways = [one.T_world_tcp.rotation @ one.grasp.approach for one in candidates]
    return Glance(
        np.array([one.detection for one in candidates], dtype=np.int64),
        tuple(one.verdict.reason for one in candidates),
        np.array([distance is not None and distance > 0 for distance in distances], dtype=bool),
        np.array(tips, dtype=np.float64).reshape(-1, 3),
        np.array(ways, dtype=np.float64).reshape(-1, 3),
        obstacles,
    )


def glanced(
    world: World, *, avoided: Mapping[int, str] = NOTHING, seed: int = 0
) -> tuple[Candidate, ...]:
    """All candidates that planning looks at first, with their verdicts up to reach and place.

    Args:
        world: of the cell with the parts found.
        avoided: indices of parts that are left alone for now, and why.
        seed: of the starting points of the inverse kinematics, as in planning.
    """
    found = propose(world, priorities=levels_of(world.cell)[0])
    reach = {arm.name: _Reach(world, arm, seed) for arm in world.cell.arms}
    return tuple(
        replace(one, verdict=refusal)
        if one.verdict.is_ok and (refusal := reach[one.arm].refusal(one)) is not None
        else one
        for one in without_avoided(avoided, found)
    )


class _Reach:
    """Where one arm gets its hand.

    Lifetime: that of the world.
    """

    def __init__(self, world: World, arm: Arm, seed: int):
        self._world, self._arm = world, arm
        self._chain: Chain = world.chains[arm.name]
        self._starts = starts_of(self._chain, arm, seed)
        turned = (T * turn for T in arm.Ts_world_place for turn in hand_turns(arm))
        self._has_place = any(map(self._reaches, turned))

    def refusal(self, candidate: Candidate) -> Verdict | None:
        """Why the arm cannot take the part there and bring it to a place; None when it can."""
        arm, world = self._arm, self._world
        is_right = bool(arm.places_for(world.detections[candidate.detection].part))
        if not is_right and not arm.Ts_world_place:
            return Verdict(Reason.NO_PLACE, Stage.PLACE)
        is_reached = False
        for T_world_tcp in self._hands(candidate):
            if not self._reaches(T_world_tcp):
                continue
            is_reached = True
            if self._has_place or (is_right and self._brings(candidate, T_world_tcp)):
                return None
        if is_reached:
            return Verdict(Reason.NO_PLACE, Stage.PLACE)
        return Verdict(Reason.OUT_OF_REACH, Stage.GRASP)

    def _hands(self, candidate: Candidate) -> list[pin.SE3]:
        """Where the hand may be: as in `resolve`, of the same grips those that fit."""
        arm, grasp = self._arm, candidate.grasp
        fits = self._world.tool_check.free(arm, candidate.detection, turns_of(arm, grasp))
        every = [candidate.T_world_tcp * T for T in grips(arm, grasp)]
        return [T for T, is_free in zip(every, fits, strict=True) if is_free] or every

    def _brings(self, candidate: Candidate, T_world_tcp: pin.SE3) -> bool:
        """Whether the arm gets a part that is held so to a place where its kind shall lie."""
        one = self._world.detections[candidate.detection]
        T_part_tcp = one.T_world_part.actInv(T_world_tcp)
        ways = ways_at_places(self._world, self._arm, candidate.detection)
        return any(self._reaches(T * T_part_tcp) for T in ways if not isinstance(T, Verdict))

    def _reaches(self, T_world_tcp: pin.SE3) -> bool:
        # Most are reached from home: all starts take ten times as long.
        for starts in (self._starts[:1], self._starts[1:]):
            _, residuals = self._chain.solve(T_world_tcp, starts)
            if is_solution(residuals).any():
                return True
        return False

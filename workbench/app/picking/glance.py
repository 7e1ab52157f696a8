"""Quick check of candidates while a person drags something, at ten answers a second.

It checks the hand at the part, as `propose` does, and whether the arm reaches the grasp and a
place.  Planning refuses whatever is refused here.  Only planning checks the motions between them.
"""

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from itertools import chain
from typing import Any, TypeVar

import numpy as np
import pinocchio as pin

from workbench.app.picking.pipeline import NO_MESSAGES
from workbench.model.candidate import Reason, Verdict
from workbench.model.cell import Arm, Cell
from workbench.model.derived.by_tcp import by_each_tcp, is_for_another
from workbench.model.geometry import Bools, Floats, Ints, put
from workbench.model.messages.message import Message
from workbench.model.part import Grasp, with_symmetry
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.hands import turns_of
from workbench.planning.collision.legs import grips, hand_turns
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import Chain, is_solution
from workbench.planning.kinematics.inverse import configurations, starts_of
from workbench.planning.picking.propose import (
    Tried,
    as_it_fits,
    candidate_of,
    grasps_of,
    groups,
    levels_of,
    refuse_where_it_lies,
    try_grasps,
)
from workbench.planning.picking.put_down import ways_at_places
from workbench.planning.placing.assembling import arm_placing

T = TypeVar("T")

Change = Mapping[str, Any]
"""Changes of a cell: fields of `Cell`, and as `libraries` grasp libraries by part."""


@dataclass(frozen=True, slots=True, eq=False)
class Glance:
    """All candidates of some detections as rows: little to send, and enough to draw.

    `detections` (n,) are indices of parts, `grasps` and `arms` names, `reasons` (n,) the verdicts.
    `is_apart` (n,): bodies that are too close do not touch.  `tips` (n, 3) [m] are the positions of
    the hand in the world, `approaches` (n, 3) its directions of travel, unit vectors.  `obstacles`
    are those of the check.
    """

    detections: Ints
    grasps: tuple[str, ...]
    arms: tuple[str, ...]
    reasons: tuple[Reason, ...]
    is_apart: Bools
    tips: Floats
    approaches: Floats
    obstacles: tuple[Obstacle, ...] = ()

    @property
    def working(self) -> Bools:
        """Whether each candidate is feasible by this check, booleans (n,)."""
        return np.array([reason is Reason.OK for reason in self.reasons], dtype=bool)


def apply_change(cell: Cell, change: Change) -> Cell:
    """A temporary cell with that change, which keeps the digest of the original.

    A digest takes as long as the check itself.  Unchanged values are the same objects, so caches
    for them work.
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
    """A copy of a frozen value with other fields, without values derived from them."""
    made = copy(value)
    put(made, **others)
    return made


def glance_by_each_tcp(
    cell: Cell,
    detections: tuple[Detection, ...],
    obstacles: tuple[Obstacle, ...],
    avoided: Mapping[int, Message] = NO_MESSAGES,
) -> Glance:
    """As `glance_at`, by one TCP of the tools after the other."""
    worlds = [World(each, detections, obstacles) for each in by_each_tcp(cell)]
    found = [glance_at(world, avoided=avoided) for world in worlds]
    return Glance(
        np.concatenate([each.detections for each in found]),
        tuple(chain.from_iterable(each.grasps for each in found)),
        tuple(chain.from_iterable(each.arms for each in found)),
        tuple(chain.from_iterable(each.reasons for each in found)),
        np.concatenate([each.is_apart for each in found]),
        np.concatenate([each.tips for each in found]),
        np.concatenate([each.approaches for each in found]),
        obstacles,
    )


def glance_at(
    world: World, *, avoided: Mapping[int, Message] = NO_MESSAGES, seed: int = 0
) -> Glance:
    """The candidates that planning checks first, with verdicts up to reach and place.

    Args:
        world: of the cell with the parts found, and the obstacles beside them.
        avoided: indices of parts that are not picked now, with the reason.
        seed: of the starting points of the inverse kinematics, as in planning.
    """
    by_part = grasps_of(world, levels_of(world.cell)[0])
    detections: list[int] = []
    grasps: list[str] = []
    arms: list[str] = []
    said: list[_Said] = []
    tips, approaches = [np.zeros((0, 3))], [np.zeros((0, 3))]
    reach = {arm.name: _Reach(world, arm, seed) for arm in world.cell.arms}
    for numbers, arm in groups(world, by_part):
        all_grasps = by_part[world.detections[numbers[0]].part]
        every = tuple(grasp for grasp in all_grasps if not is_for_another(grasp, arm.tool))
        if not every:
            continue
        hands = try_grasps(world, numbers, every, arm)
        for n, number in enumerate(numbers):
            detections += [number] * len(every)
            grasps += [grasp.name for grasp in every]
            arms += [arm.name] * len(every)
            if number in avoided:
                said += [(Reason.DISABLED, False)] * len(every)
            elif refusal := refuse_where_it_lies(world, number):
                said += [(refusal.reason, False)] * len(every)
            elif world.detections[number].roll_known:
                said += [
                    reach[arm.name].describe(hands, n, number, k, g) for k, g in enumerate(every)
                ]
            else:
                said += [reach[arm.name].said_at_every_turn(number, grasp) for grasp in every]
        ways = np.array([grasp.approach for grasp in every])
        tips.append(hands.p.reshape(-1, 3))
        approaches.append(np.einsum("nkij,kj->nki", hands.R, ways).reshape(-1, 3))
    return Glance(
        np.array(detections, dtype=np.int64),
        tuple(grasps),
        tuple(arms),
        tuple(reason for reason, _ in said),
        np.array([is_apart for _, is_apart in said], dtype=bool),
        np.concatenate(tips),
        np.concatenate(approaches),
        world.obstacles,
    )


_Said = tuple[Reason, bool]
"""Reason of a candidate, and whether bodies that are too close do not touch."""


class _Reach:
    """Reach of one arm.

    Lifetime: that of the world.
    """

    def __init__(self, world: World, arm: Arm, seed: int):
        self._world, self._arm = world, arm
        self._chain: Chain = world.chains[arm.name]
        self._starts = starts_of(self._chain, arm, seed)
        turned = (T * turn for T in arm.Ts_world_place for turn in hand_turns(arm.tool))
        self._has_place = any(map(self._reaches, turned))

    def describe(self, hands: Tried, n: int, number: int, k: int, grasp: Grasp) -> _Said:
        """The verdict on grasp k at this detection, the n-th of those tried."""
        refusal = hands.refusals[k]
        if refusal is not None:
            return refusal.reason, False
        fit = hands.fits[number, k]
        if fit.pair is not None:
            return Reason.TOOL_COLLISION, not fit.is_touching
        T_world_tcp = pin.SE3(hands.R[n, k], hands.p[n, k])
        return self._reason(number, as_it_fits(self._arm, grasp, fit), T_world_tcp), False

    def said_at_every_turn(self, number: int, grasp: Grasp) -> _Said:
        """The verdict on a part of unknown roll, which takes longer."""
        candidate = candidate_of(self._world, number, grasp, self._arm)
        if candidate.verdict.is_ok:
            return self._reason(number, candidate.grasp, candidate.T_world_tcp), False
        return candidate.verdict.reason, (candidate.verdict.distance or 0.0) > 0.0

    def _reason(self, number: int, grasp: Grasp, T_world_tcp: pin.SE3) -> Reason:
        """Why the arm cannot take the part there and bring it to a place, or that it can."""
        arm = arm_placing(self._world, self._arm, number)
        if isinstance(arm, Verdict):
            return arm.reason
        is_right = bool(arm.places_for(self._world.detections[number].part))
        has_place = self._has_place and bool(arm.Ts_world_place)
        if not is_right and not arm.Ts_world_place:
            return Reason.NO_PLACE
        is_reached = False
        for T in self._hands(number, grasp, T_world_tcp):
            if self._reaches(T):
                is_reached = True
                if has_place or (is_right and self._brings(arm, number, T)):
                    return Reason.OK
        return Reason.NO_PLACE if is_reached else Reason.OUT_OF_REACH

    def _hands(self, number: int, grasp: Grasp, T_world_tcp: pin.SE3) -> list[pin.SE3]:
        """Possible poses of the hand: as in `resolve`, those of equal grips that fit."""
        fits = self._world.tool_check.free(self._arm, number, turns_of(self._arm.tool, grasp))
        every = [T_world_tcp * T for T in grips(self._arm.tool, grasp)]
        return [T for T, is_free in zip(every, fits, strict=True) if is_free] or every

    def _brings(self, arm: Arm, number: int, T_world_tcp: pin.SE3) -> bool:
        """Whether the arm can bring a part in this grasp to a place of its kind."""
        T_part_tcp = self._world.detections[number].T_world_part.actInv(T_world_tcp)
        ways = ways_at_places(self._world, arm, number)
        return any(self._reaches(T * T_part_tcp) for T in ways if not isinstance(T, Verdict))

    def _reaches(self, T_world_tcp: pin.SE3) -> bool:
        # Most are reached from home: all configurations take ten times as long.
        _, residuals = self._chain.solve(T_world_tcp, self._starts[:1])
        if is_solution(residuals).any():
            return True
        return len(configurations(self._chain, T_world_tcp, self._starts[1:]).q) > 0

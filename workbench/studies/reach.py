"""How far an arm of a cell gets: from home, into its bin, to its places."""

from dataclasses import dataclass
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.derived.by_tcp import is_for
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Bin, Grasp, Part
from workbench.model.scan import Detection
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.legs import grips
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.grasps.put_poses import ways_to_lie
from workbench.studies.targets import Outcome, Target, judge_targets, looked_at, starts_of

GRID = (5, 5, 3)
"""Tool poses along the bin's length, width and depth."""

VERTICAL_TURNS = (0.0, np.pi / 4, np.pi / 2, 3 * np.pi / 4)
"""[rad] About the vertical, each at every place of the grid."""


@dataclass(frozen=True, slots=True, eq=False)
class PlacedPart:
    """A place, by its number from 1, with a part of one kind at it, and who could bring it there.

    `stands_in` are labels of what the part would be nearer to than the margin in each way in which
    it may lie, and empty otherwise.  Of `grasps` that the arm may use, at `clear` the hand gets to
    the place and touches nothing, at `reached` it gets there; `away` [m] is how far the others stay
    away at best, None when there is none.
    """

    number: int
    part: str
    stands_in: str
    grasps: int
    reached: int
    is_clear: bool
    away: float

    @property
    def outcome(self) -> Outcome:
        """In the words for poses of the hand."""
        if self.is_clear:
            return "clear"
        return "in collision" if self.stands_in or self.reached else "out of reach"


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """What one arm can do.

    `at_home` is what it touches at home, None when it is clear; `bin` are tool poses in the bin,
    pointing straight down, `places` those where it may release a part.  `part_places` are those
    where parts have to lie, each with every kind that may lie there.
    """

    arm: str
    at_home: Contact | None
    bin: tuple[Target, ...]
    places: tuple[Target, ...]
    part_places: tuple[PlacedPart, ...] = ()


def reach_of(cell: Cell, arm: Arm, *, seed: int = 0) -> Reach:
    """Look at home, bin and places of one arm, the others standing at home.

    Args:
        cell: without parts in its bin.
        arm: one of its arms.
        seed: of the starting points of the inverse kinematics.
    """
    world = World(cell, ())
    moving, opened = frozenset({arm.name}), {arm.name: arm.tool.stroke[1]}
    world.enter(LegPhase(moving, opened))
    at_home = world.contact(world.configuration({}))
    world.enter(LegPhase(moving, opened, straight=moving))
    bin_targets = judge_targets(world, arm, _down_poses(cell.bin), seed)
    places = judge_targets(world, arm, list(arm.Ts_world_place), seed)
    placed = tuple(
        _place(cell, arm, number, part, seed)
        for number, place in enumerate(arm.part_places, start=1)
        for part in cell.parts
        if place.is_for(part.name)
    )
    return Reach(arm.name, at_home, tuple(bin_targets), tuple(places), placed)


def _place(cell: Cell, arm: Arm, number: int, part: Part, seed: int) -> PlacedPart:
    """A part at one place, held by each of its grasps in turn, the way there left out."""
    place = arm.part_places[number - 1]
    world = World(cell, (Detection(part.name, place.T_world_part),))
    ways = ways_to_lie(place, part.symmetry)
    met = [world.part_ways.standing_in(0, T, cell.policy.margin) for T in ways]
    right = [T for T, label in zip(ways, met, strict=True) if label is None]
    grasps = [grasp for grasp in part.grasps if _may(arm, grasp)]
    starts = starts_of(world, arm, seed)
    reached, away = 0, np.inf
    for grasp in grasps if right else ():
        outcomes: set[Outcome] = set()
        for T_world_part, T_turn in product(right, grips(arm.tool, grasp)):
            T_tcp_part = (grasp.T_part_tcp * T_turn).inverse()
            held = {arm.name: (0, T_tcp_part)}
            world.enter(LegPhase(frozenset({arm.name}), {arm.name: grasp.grip}, held))
            T_world_tcp = T_world_part * T_tcp_part.inverse()
            target, off = looked_at(world, arm, T_world_tcp, starts)
            if target.outcome == "clear":
                return PlacedPart(number, part.name, "", len(grasps), 1, True, 0.0)
            outcomes.add(target.outcome)
            away = min(away, off)
        reached += "in collision" in outcomes
    stands_in = "" if right else str(met[0])
    return PlacedPart(number, part.name, stands_in, len(grasps), reached, False, away)


def _may(arm: Arm, grasp: Grasp) -> bool:
    """Whether an arm may use a grasp at all."""
    is_allowed = not grasp.arms or arm.name in grasp.arms
    is_of_tool = grasp.tool in ("", arm.tool.name) and is_for(grasp, arm.tool)
    return grasp.is_enabled and is_allowed and is_of_tool


def _down_poses(bin: Bin) -> list[pin.SE3]:
    """Tool poses over a grid in the bin, clear of walls and floor by a sixth of its sizes."""
    shares = [(np.arange(count) + 0.5) / count for count in GRID]
    length, width, height = bin.size
    poses: list[pin.SE3] = []
    for x in (shares[0] - 0.5) * length:
        for y in (shares[1] - 0.5) * width:
            for z in shares[2] * height:
                for turn in VERTICAL_TURNS:
                    T_bin_tcp = pose_from_rpy((x, y, z), (np.pi, 0.0, turn))
                    poses.append(bin.T_world_bin * T_bin_tcp)
    return poses

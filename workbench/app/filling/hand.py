"""One tool at one part: the grips of the raster, and the families chosen."""

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from workbench.app.filling.families import Family, Grower, family_of
from workbench.app.filling.round_bodies import round_bodies
from workbench.app.filling.work import FIT, PIECE, WAY, Work
from workbench.model.cell import Arm, Cell
from workbench.model.derived.by_tcp import is_for
from workbench.model.geometry import Bools
from workbench.model.part import Entry, Grasp, Part, widen_grasp
from workbench.model.part_edits import grasp_of
from workbench.planning.collision.hands import Hands
from workbench.planning.collision.tool_check import ToolCheck
from workbench.planning.grasps.grasp_check import GraspCheck, GraspChecker
from workbench.planning.grasps.grip_raster import grips_of
from workbench.planning.kinematics.quickness import hand_acceleration

RASTER = 24000
"""Grips of the raster that are tried."""

PAD = 50e-6
"""[m2] A pad that touches more holds no better."""


@dataclass(eq=False)
class Hand:
    """A tool, the arms that carry it, and what it can do with the part.

    `hands` are the grips of the raster that are tried, `families` those of the library and new
    ones.

    Lifetime: of one filling.
    """

    arms: tuple[Arm, ...]
    grower: Grower
    hands: Hands
    families: list[Family]
    least_air: float | None
    useless: set[int] = field(default_factory=set[int])

    @property
    def arm(self) -> Arm:
        """The first of the arms."""
        return self.arms[0]

    def free(self, tools: ToolCheck, number: int) -> Bools:
        """Which grips of the raster (n,) fit at a part among its neighbours, no unit."""
        self._count(len(self.hands.turn))
        return tools.free(self.arm, number, self.hands)

    def fits(self, family: Family, tools: ToolCheck, number: int) -> bool:
        """Whether it fits in any way of a family at a part among its neighbours."""
        self._count(len(family.p))
        return family.fits(tools, self.arm, number)

    def free_ways(self, family: Family, tools: ToolCheck, number: int) -> Bools:
        """Which of the ways (w,) of a family fit there, no unit."""
        self._count(len(family.p))
        return family.free(tools, self.arm, number)

    def _count(self, ways: int) -> None:
        pieces = len(self.grower.part.pieces)
        self.grower.work.add(FIT + ways * (WAY + PIECE * pieces))

    def raw(self, k: int) -> Grasp:
        """A grip of the raster as it was tried, whether or not it holds."""
        T = pin.SE3(self.hands.R[k], self.hands.p[k]) * self.arm.tool.T_flange_tcp
        opening, grip = self.hands.opening[k].tolist()
        return Grasp("", T, opening, grip)

    def grip(self, k: int) -> tuple[Grasp, GraspCheck] | None:
        """A grip of the raster as a grasp; None where it does not hold, once and for all."""
        if k in self.useless:
            return None
        found = self.grower.looked_at(self.raw(k).T_part_tcp)
        if found is None:
            self.useless.add(k)
        return found

    def goodness(self, grasp: Grasp, check: GraspCheck) -> float:
        """How well a grip holds, 0 to 1: by what the pads touch and how near the middle."""
        part = self.grower.part
        size = float(np.linalg.norm(np.ptp(part.mesh.points, axis=0)))
        off = float(np.linalg.norm(grasp.T_part_tcp.translation - self.grower.centre))
        near = max(0.0, 1.0 - 2 * off / size)
        area = 1.0 if check.hold is None else min(min(check.hold.areas) / PAD, 1.0)
        return 0.5 * near + 0.5 * area


def hands_for(cell: Cell, part: Part, seed: int, work: Work) -> list[Hand]:
    """A hand for each tool of the cell that has something to hold the part by.

    Args:
        cell: whose tools.
        part: with its library.
        seed: of which grips are tried.
        work: that counts what they do.
    """
    found: list[Hand] = []
    for name in dict.fromkeys(arm.tool.name for arm in cell.arms):
        arms = tuple(arm for arm in cell.arms if arm.tool.name == name)
        arm, least_air = arms[0], cell.policy.least_air
        acceleration = max(hand_acceleration(cell, carrier) for carrier in arms)
        checker = GraspChecker(part, arm.tool, acceleration)
        if checker.pads is None and checker.cup is None:
            continue
        grower = Grower(checker, round_bodies(part, checker), least_air, work)
        grips = grips_of(part, arm.tool)
        if not len(grips.hands.turn):
            continue
        rng = np.random.default_rng(seed)
        chosen = np.sort(rng.permutation(len(grips.hands.turn))[:RASTER])
        families = [
            family_of(part, arm, entry, least_air)
            for entry in part.library.entries
            if _is_for(part, entry, arms)
        ]
        found.append(Hand(arms, grower, grips.hands.some(chosen), families, least_air))
    return found


def _is_for(part: Part, entry: Entry, arms: tuple[Arm, ...]) -> bool:
    grasp = widen_grasp(grasp_of(entry), part.tolerance)
    low, high = arms[0].tool.stroke
    return (
        grasp.is_enabled
        and grasp.tool in ("", arms[0].tool.name)
        and is_for(grasp, arms[0].tool)
        and (not grasp.arms or any(arm.name in grasp.arms for arm in arms))
        and (not arms[0].tool.fingers or low <= grasp.opening <= high)
    )

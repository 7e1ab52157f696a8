"""The tool alone, floating in the bin: no arm, so no inverse kinematics is needed.

Most candidates are refused here, so all ways of all grasps at all parts are judged in one compiled
piece; what stands near a part is looked up once for all of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Bools, Ints
from workbench.model.part import Grasp, Part
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.bodies import coal_shape, extent, still_bodies, tool_shapes
from workbench.planning.collision.gjk import cores_of
from workbench.planning.collision.hands import (
    Around,
    Hands,
    Places,
    first_fits,
    hands_of,
)

Met = tuple[tuple[str, str], float]
"""Labels of tool and obstacle, and their distance [m]."""


@dataclass(frozen=True, slots=True)
class Fit:
    """How a hand fits at a part: by which way, and what it meets in its first way where by none.

    `opening` [m] and `turn` (of the `grips`) are those of the way.  `is_closed`: the first way is
    free as the hand arrives, and met is what it does as the fingers close; `pair` are the numbers
    of tool solid and obstacle (`ToolCheck.told`), None where a way fits.
    """

    opening: float
    turn: int
    is_closed: bool
    pair: tuple[int, int] | None


class ToolCheck:
    """What is around the tools of a cell, and what they would meet.

    Lifetime: as long as cell and detections.
    """

    def __init__(
        self,
        cell: Cell,
        detections: tuple[Detection, ...],
        obstacles: tuple[Obstacle, ...] = (),
    ):
        self._margin, self._least_air = cell.policy.near_margin, cell.policy.least_air
        self._parts = [cell.part(one.part) for one in detections]
        self._poses = [one.T_world_part for one in detections]
        # The bin first: where the tool meets several things, that one is named.
        still = sorted(
            still_bodies(cell, detections, obstacles), key=lambda body: body.kind != "bin"
        )
        self._labels = [body.label for body in still]
        self._numbers = np.array([int(b.owner) if b.kind == "part" else -1 for b in still])
        self._shapes = [body.shape for body in still]
        self._geometry = [coal_shape(shape) for shape in self._shapes]
        poses = [body.T_joint_body for body in still]
        extents = [extent(shape) for shape in self._shapes]
        self._transforms = [coal.Transform3s(T.rotation, T.translation) for T in poses]
        self._R = np.array([T.rotation for T in poses])
        self._centres = np.array([T.act(e[0]) for T, e in zip(poses, extents, strict=True)])
        self._halves = np.array([half for _, half, _ in extents])
        self._around: dict[str, Around] = {}
        self._request = coal.DistanceRequest()
        self._tools = {arm.name: tool_shapes(arm.tool) for arm in cell.arms}

    def contact(
        self, arm: Arm, T_world_tcp: pin.SE3, opening: float, target: int, press: float
    ) -> Met | None:
        """The first obstacle closer to the tool than its margin, and its distance [m].

        The part to be taken has no margin; the tool may cut into it by `press` [m].
        """
        pair = self._contact(arm, T_world_tcp, opening, target, press)
        return None if pair is None else self.told(arm, T_world_tcp, opening, pair)

    def _contact(
        self, arm: Arm, T_world_tcp: pin.SE3, opening: float, target: int, press: float
    ) -> tuple[int, int] | None:
        for number, tool in enumerate(self._tools[arm.name]):
            T = tool.at(arm.tool, T_world_tcp, opening)
            offset = np.einsum("gji,gj->gi", self._R, T.act(tool.centre) - self._centres)
            gap = np.linalg.norm(np.maximum(np.abs(offset) - self._halves, 0.0), axis=1)
            for g in np.flatnonzero(gap - tool.radius < self._margin).tolist():
                margin = -press if self._numbers[g] == target else self._margin
                if self.told(arm, T_world_tcp, opening, (number, g))[1] < margin:
                    return number, g
        return None

    def told(self, arm: Arm, T_world_tcp: pin.SE3, opening: float, pair: tuple[int, int]) -> Met:
        """The labels and the distance [m] of a pair of tool solid and obstacle."""
        number, g = pair
        tool = self._tools[arm.name][number]
        T = tool.at(arm.tool, T_world_tcp, opening)
        distance = coal.distance(
            tool.geometry,
            coal.Transform3s(T.rotation, T.translation),
            self._geometry[g],
            self._transforms[g],
            self._request,
            coal.DistanceResult(),
        )
        return (f"{arm.name} {tool.name}", self._labels[g]), float(distance)

    def fits(
        self, arm: Arm, part: Part, grasps: tuple[Grasp, ...], rows: Sequence[tuple[int, int]]
    ) -> list[Fit]:
        """How an arm's hand fits: by the first way of each grasp in which it meets nothing.

        Fingers are looked at as they arrive and as they are closed.  The ways are those of
        `hands_of`.

        Args:
            arm: whose tool.
            part: of one kind are all that are taken.
            grasps: of it.
            rows: numbers of detections and grasps; those of a detection stand together.
        """
        if not rows:
            return []
        hands = hands_of(arm, part, grasps, self._least_air, self._margin)
        around = self._surroundings(arm)
        numbers = list(dict.fromkeys(number for number, _ in rows))
        if not around.cores.known.all():
            return [self._slowly(arm, grasps, hands, *row) for row in rows]
        place = {number: k for k, number in enumerate(numbers)}
        places = self._places(numbers, hands, around)
        ways, met = first_fits(
            hands,
            np.array([grasp for _, grasp in rows]),
            np.array([place[number] for number, _ in rows]),
            len(part.pieces),
            places,
            self._margin,
            around,
        )
        count = len(self._shapes)
        found: list[Fit] = []
        for (_, grasp), way, (phase, code) in zip(rows, ways.tolist(), met.tolist(), strict=True):
            pair = None if way >= 0 else (code // count, code % count)
            w = way if way >= 0 else int(hands.first[grasp])
            opening, turn = float(hands.opening[w, 0]), int(hands.turn[w])
            found.append(Fit(opening, turn, phase == 1, pair))
        return found

    def free(self, arm: Arm, part: Part, number: int, hands: Hands) -> Bools:
        """Which grasps of `hands` (g,) fit at a detection, whatever they do to the part itself.

        Booleans, no unit.
        """
        around, count = self._surroundings(arm), len(hands.first) - 1
        if not around.cores.known.all():
            return np.ones(count, bool)  # a closer look follows
        places = self._places([number], hands, around)
        every, pieces = np.arange(count), len(part.pieces)
        ways, _ = first_fits(hands, every, 0 * every, pieces, places, self._margin, around)
        return ways >= 0

    def _slowly(
        self, arm: Arm, grasps: tuple[Grasp, ...], hands: Hands, number: int, grasp: int
    ) -> Fit:
        """Where a body is not convex, so that compiled code does not know it."""
        refusal: Fit | None = None
        for w in range(int(hands.first[grasp]), int(hands.first[grasp + 1])):
            T_part_flange = pin.SE3(hands.R[w], hands.p[w])
            T_world_tcp = self._poses[number] * T_part_flange * arm.tool.T_flange_tcp
            opening, turn = float(hands.opening[w, 0]), int(hands.turn[w])
            pair = None
            for is_closed in (False, True) if arm.tool.fingers else (True,):
                press = arm.tool.press if is_closed else 0.0
                wide = float(hands.opening[w, int(is_closed)])
                pair = self._contact(arm, T_world_tcp, wide, number, press)
                if pair is not None:
                    refusal = refusal or Fit(opening, turn, is_closed, pair)
                    break
            if pair is None:
                return Fit(opening, turn, False, None)
        assert refusal is not None  # every grasp has a way
        return refusal

    def _places(self, numbers: Sequence[int], hands: Hands, around: Around) -> Places:
        """Where parts of a kind lie, and what stands so near that a hand at them might meet it."""
        Rs = np.array([self._poses[number].rotation for number in numbers])
        ps = np.array([self._poses[number].translation for number in numbers])
        solids = np.linalg.norm(around.p_tool, axis=1) + around.radius
        # Farther than this nothing of the tool is from the part.
        reach = float(np.linalg.norm(hands.p, axis=1).max(initial=0.0) + solids.max(initial=0.0))
        reach += float(hands.opening.max(initial=0.0)) / 2 + self._margin
        near: list[Ints] = []
        for p in ps:
            offset = np.einsum("gji,gj->gi", self._R, p - self._centres)
            gap = np.linalg.norm(np.maximum(np.abs(offset) - self._halves, 0.0), axis=1)
            near.append(np.flatnonzero(gap < reach))
        return Places(
            Rs,
            ps,
            np.array(numbers),
            np.array([int(np.argmax(self._numbers == number)) for number in numbers]),
            np.concatenate(near),
            np.cumsum([0, *map(len, near)]),
        )

    def _surroundings(self, arm: Arm) -> Around:
        if arm.name not in self._around:
            tools = self._tools[arm.name]
            shapes = [tool.solid.shape for tool in tools] + self._shapes
            self._around[arm.name] = Around(
                np.array([tool.T_flange_body.rotation for tool in tools]),
                np.array([tool.T_flange_body.act(tool.centre) for tool in tools]),
                np.array([tool.direction for tool in tools]),
                np.array([extent(tool.solid.shape)[1] for tool in tools]),
                np.array([tool.radius for tool in tools]),
                self._R,
                self._centres,
                self._halves,
                self._numbers,
                cores_of(shapes, np.array([extent(shape)[0] for shape in shapes])),
            )
        return self._around[arm.name]

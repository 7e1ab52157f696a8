"""The tool alone, floating in the bin: no arm, so no inverse kinematics is needed.

Most candidates are refused here, so all ways of all grasps at all parts are judged in one compiled
piece; what stands near a part is looked up once for all of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Policy
from workbench.model.geometry import Bools, Floats
from workbench.model.part import Grasp
from workbench.planning.collision.around import Around, Places, first_contact, first_fits, which_fit
from workbench.planning.collision.bodies import tool_shapes
from workbench.planning.collision.distances.measuring import distance
from workbench.planning.collision.hands import Hands, closed_press, hands_of
from workbench.planning.collision.part_ways import kept_on_ways, steps_along
from workbench.planning.collision.surroundings import Surroundings

Met = tuple[tuple[str, str], float]
"""Labels of tool and obstacle, and their distance [m]."""


@dataclass(frozen=True, slots=True)
class Fit:
    """How a hand fits at a part: by which way, and what it meets in its first way where by none.

    `opening` [m] and `turn` (of the `grips`) are those of the way.  `is_closed`: the first way is
    free as the hand arrives, and met is what it does as the fingers close; `pair` are the numbers
    of tool solid and obstacle (`ToolCheck.measure_pair`), None where a way fits; `is_touching` says
    that the two touch, not only come too near.
    """

    opening: float
    turn: int
    is_closed: bool
    pair: tuple[int, int] | None
    is_touching: bool = False


class ToolCheck:
    """The tools of a cell alone, and what they would meet of what stands around them.

    `grips` are those that a search has found, by number of the detection and name of the tool.

    Lifetime: as long as the surroundings.
    """

    def __init__(self, surroundings: Surroundings, policy: Policy | None = None) -> None:
        """Check by a policy; None: by that of the cell."""
        cell = surroundings.cell
        policy = policy or cell.policy
        self._margin, self._least_air = policy.near_margin, policy.least_air
        self._on_ways = kept_on_ways(cell)
        self._surroundings = surroundings
        self._around: dict[str, Around] = {}
        self._tools = {arm.name: tool_shapes(arm.tool) for arm in cell.arms}
        self.grips: dict[tuple[int, str], tuple[Grasp, ...]] = {}

    def contact(
        self, arm: Arm, T_world_tcp: pin.SE3, opening: float, target: int, press: float
    ) -> Met | None:
        """The first obstacle closer to the tool than its margin, and its distance [m].

        The part to be taken has no margin; the tool may cut into it by `press` [m].
        """
        pair = self._contact(arm, T_world_tcp, opening, target, press)
        return None if pair is None else self.measure_pair(arm, T_world_tcp, opening, pair)

    def _contact(
        self, arm: Arm, T_world_tcp: pin.SE3, opening: float, target: int, press: float
    ) -> tuple[int, int] | None:
        for number, tool in enumerate(self._tools[arm.name]):
            T = tool.at(arm.tool, T_world_tcp, opening)
            gaps = self._surroundings.gaps(T.act(tool.centre))
            for g in np.flatnonzero(gaps - tool.radius < self._margin).tolist():
                margin = -press if self._surroundings.owner[g] == target else self._margin
                if self.measure_pair(arm, T_world_tcp, opening, (number, g))[1] < margin:
                    return number, g
        return None

    def measure_pair(
        self, arm: Arm, T_world_tcp: pin.SE3, opening: float, pair: tuple[int, int]
    ) -> Met:
        """The labels and the distance [m] of a pair of tool solid and obstacle."""
        number, g = pair
        tool = self._tools[arm.name][number]
        T = tool.at(arm.tool, T_world_tcp, opening)
        body = self._surroundings.bodies[g]
        far = distance(tool.solid.shape, T, body.shape, body.T_joint_body)
        return (f"{arm.name} {tool.name}", body.label), far

    def fits(
        self, arm: Arm, grasps: tuple[Grasp, ...], rows: Sequence[tuple[int, int]]
    ) -> list[Fit]:
        """How an arm's hand fits: by the first way of each grasp in which it meets nothing.

        Fingers are checked as they arrive and as they are closed.  The ways are those of
        `hands_of`.

        Args:
            arm: whose tool.
            grasps: of the part.
            rows: numbers of detections and grasps; those of a detection stand together.  All are of
                one part and their pieces the same (`rolled.room_of`).
        """
        if not rows:
            return []
        pieces = self._surroundings.pieces[rows[0][0]]
        press, air = self._press(arm, rows[0][0]), self._least_air
        if air is not None:
            air += press - arm.tool.press  # the part may be as much larger
        hands = hands_of(arm.tool, pieces, grasps, air, self._margin, press)
        around = self._around_arm(arm)
        numbers = list(dict.fromkeys(number for number, _ in rows))
        if not around.cores.known.all():
            return [self._slowly(arm, hands, *row) for row in rows]
        place = {number: k for k, number in enumerate(numbers)}
        places = self._places(numbers, hands, around)
        ways, met = first_fits(
            hands,
            np.array([grasp for _, grasp in rows]),
            np.array([place[number] for number, _ in rows]),
            len(pieces),
            places,
            self._margin,
            around,
        )
        count = len(self._surroundings.bodies)
        found: list[Fit] = []
        pairs = met.tolist()
        for (_, grasp), way, (phase, code, touches) in zip(rows, ways.tolist(), pairs, strict=True):
            pair = None if way >= 0 else (code // count, code % count)
            w = way if way >= 0 else int(hands.first[grasp])
            opening, turn = float(hands.opening[w, 0]), int(hands.turn[w])
            found.append(Fit(opening, turn, phase == 1, pair, touches == 1))
        return found

    def free(self, arm: Arm, number: int, hands: Hands) -> Bools:
        """Which grasps of `hands` (g,) fit at a detection, whatever they do to the part itself.

        Booleans, no unit.
        """
        around, count = self._around_arm(arm), len(hands.first) - 1
        if not around.cores.known.all():
            return np.ones(count, bool)  # a closer look follows
        places = self._places([number], hands, around)
        pieces = len(self._surroundings.pieces[number])
        if len(hands.turn) == count:
            return which_fit(hands, pieces, places, self._margin, around)
        every = np.arange(count)
        ways, _ = first_fits(hands, every, 0 * every, pieces, places, self._margin, around)
        return ways >= 0

    def on_way(
        self, arm: Arm, T_world_tcp: pin.SE3, opening: float, number: int, way: Floats
    ) -> tuple[tuple[str, str], float] | None:
        """What the tool meets on a linear motion, and after how much of it [m]; None for nothing.

        What counts is what comes nearer than `kept_on_ways`.

        Args:
            arm: whose tool.
            T_world_tcp: where the way begins.
            opening: [m] of the fingers.
            number: of the part that the tool takes along.
            way: (3,) [m] in the world.
        """
        around, most = self._around_arm(arm), float(np.linalg.norm(way))
        if not around.cores.known.all() or most == 0.0:
            return None  # a closer look follows
        T = T_world_tcp * arm.tool.T_flange_tcp.inverse()
        far = steps_along(0.0, most)
        places = T.translation + far[:, None] * way / most
        R, keeps = np.array(T.rotation, order="C"), self._on_ways
        k, code = first_contact(R, places, opening, number, keeps, around)
        if k < 0:
            return None
        number, g = divmod(code, len(self._surroundings.bodies))
        labels = (
            f"{arm.name} {self._tools[arm.name][number].name}",
            self._surroundings.bodies[g].label,
        )
        return labels, float(far[k])

    def _slowly(self, arm: Arm, hands: Hands, number: int, grasp: int) -> Fit:
        """Where a body is not convex, so that compiled code does not know it."""
        T_world_part = self._surroundings.detections[number].T_world_part
        refusal: Fit | None = None
        for w in range(int(hands.first[grasp]), int(hands.first[grasp + 1])):
            T_world_flange = T_world_part * pin.SE3(hands.R[w], hands.p[w])
            T_world_tcp = T_world_flange * arm.tool.T_flange_tcp
            opening, turn = float(hands.opening[w, 0]), int(hands.turn[w])
            pair = None
            for is_closed in (False, True) if arm.tool.fingers else (True,):
                press = self._press(arm, number) if is_closed else 0.0
                wide = float(hands.opening[w, int(is_closed)])
                pair = self._contact(arm, T_world_tcp, wide, number, press)
                if pair is not None:
                    touches = self.measure_pair(arm, T_world_tcp, wide, pair)[1] <= 0
                    refusal = refusal or Fit(opening, turn, is_closed, pair, touches)
                    break
            if pair is None:
                return Fit(opening, turn, False, None)
        assert refusal is not None  # every grasp has a way
        return refusal

    def _press(self, arm: Arm, number: int) -> float:
        part = self._surroundings.detections[number].part
        return closed_press(arm.tool, self._surroundings.cell.part(part))

    def _places(self, numbers: Sequence[int], hands: Hands, around: Around) -> Places:
        """Where parts of a kind lie, and what stands so near that a hand at them might meet it."""
        poses = [self._surroundings.detections[number].T_world_part for number in numbers]
        ps = np.array([T.translation for T in poses])
        solids = np.linalg.norm(around.p_tool, axis=1) + around.radius
        # Farther than this nothing of the tool is from the part.
        reach = float(np.linalg.norm(hands.p, axis=1).max(initial=0.0) + solids.max(initial=0.0))
        reach += float(hands.opening.max(initial=0.0)) / 2 + self._margin
        near = [np.flatnonzero(self._surroundings.gaps(p) < reach) for p in ps]
        return Places(
            np.array([T.rotation for T in poses]),
            ps,
            np.array(numbers),
            np.array([int(np.argmax(self._surroundings.owner == number)) for number in numbers]),
            np.concatenate(near),
            np.cumsum([0, *map(len, near)]),
        )

    def _around_arm(self, arm: Arm) -> Around:
        if arm.name not in self._around:
            self._around[arm.name] = self._surroundings.around(
                [
                    (tool.solid.shape, tool.T_flange_body, tool.direction)
                    for tool in self._tools[arm.name]
                ]
            )
        return self._around[arm.name]

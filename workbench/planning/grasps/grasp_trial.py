"""Whether grasps work for a part anywhere in the bin: tool against bin, then inverse kinematics."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numba import njit

from workbench.model.cell import Arm, Cell, Tool
from workbench.model.derived.by_tcp import is_for
from workbench.model.geometry import Bools, Box, Floats
from workbench.model.part import Grasp, Part
from workbench.planning.collision.legs import grips
from workbench.planning.collision.surroundings import Surroundings
from workbench.planning.collision.tool_check import ToolCheck
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.grasps.pads import outline
from workbench.planning.kinematics.chain import Chain, chain_of, is_solution
from workbench.planning.kinematics.inverse import configurations

IK_STARTS = 6
"""Starting points of the inverse kinematics, in addition to the last answer."""

NO_TARGET = -2
"""The part is not among what the tool is checked against: `GraspChecker` has done that."""


class Trial:
    """One part in the bin, and every arm's tool and kinematics, prepared.

    Lifetime: of one search.
    """

    def __init__(self, cell: Cell, part: Part):
        self.cell = cell
        self.part = part
        surroundings = Surroundings(cell, ())
        self._check = ToolCheck(surroundings)
        self._chains = [chain_of(cell, arm) for arm in cell.arms]
        self._starts = [
            _starts(chain, arm) for chain, arm in zip(self._chains, cell.arms, strict=True)
        ]
        self._last = [starts[0] for starts in self._starts]
        self._points = np.asarray(part.mesh.points)
        self._boxes = _boxes(surroundings)
        self._corners = {arm.tool.name: _corners(arm.tool) for arm in cell.arms}
        self.checkers = {arm.name: GraspChecker(part, arm.tool) for arm in cell.arms}

    def poses(
        self, up: Floats, number: int, turns: int, places: tuple[tuple[float, float], ...]
    ) -> list[pin.SE3]:
        """`T_world_part` with a unit direction (3,) of the part up, standing on the bin's floor."""
        z = np.array([0.0, 0.0, 1.0])
        axis = np.cross(up, z)
        sine, cosine = float(np.linalg.norm(axis)), float(up @ z)
        across = axis / sine if sine > 1e-9 else np.array([1.0, 0.0, 0.0])
        upright = pin.exp3(across * np.arctan2(sine, cosine))
        # Neighbours on the sphere are turned differently: together they stand for more turns.
        first = (number * 0.6180339887 % 1.0) * 2 * np.pi / turns
        found: list[pin.SE3] = []
        for turn in first + np.arange(turns) * 2 * np.pi / turns:
            R = pin.exp3(z * turn) @ upright
            turned = self._points @ R.T
            low, high = turned.min(axis=0), turned.max(axis=0)
            for x, y in places:
                length, width, _ = self.cell.bin.size
                # As far out as it still lies between the walls.
                room = np.maximum(np.array([length, width]) - (high - low)[:2], 0.0) / 2
                at = np.clip([x * length, y * width], -room, room)
                p = np.array([*(at - (low + high)[:2] / 2), -low[2]])
                found.append(self.cell.bin.T_world_bin * pin.SE3(R, p))
        return found

    def usable(self, grasps: tuple[Grasp, ...]) -> Bools:
        """True (g, a) where an arm may use a grasp: switched on, allowed, right for its tool."""
        return np.array(
            [
                [
                    grasp.is_enabled
                    and (not grasp.arms or arm.name in grasp.arms)
                    and (not grasp.tool or grasp.tool == arm.tool.name)
                    and is_for(grasp, arm.tool)
                    and not any(
                        finding.kind in ("cut", "stroke", "approach")
                        for finding in self.checkers[arm.name].check(grasp).findings
                    )
                    for arm in self.cell.arms
                ]
                for grasp in grasps
            ],
            dtype=bool,
        ).reshape(len(grasps), len(self.cell.arms))

    def works(
        self, Ts_world_part: Sequence[pin.SE3], grasps: Sequence[Grasp], usable: Bools
    ) -> Bools:
        """True (p, g, a) where a grasp works with an arm for a part at a pose.

        Args:
            Ts_world_part: where the part lies, alone.
            grasps: of the part.
            usable: (g, a) those worth a try.
        """
        works = np.zeros((len(Ts_world_part), *usable.shape), bool)
        tools = {arm.tool.name: arm.tool for arm in self.cell.arms}
        for g, grasp in enumerate(grasps):
            for tool in tools.values():
                arms = [
                    a
                    for a, arm in enumerate(self.cell.arms)
                    if usable[g, a] and arm.tool.name == tool.name
                ]
                if arms:
                    self._try(Ts_world_part, grasp, tool, arms, works[:, g])
        return works

    def _try(
        self, Ts: Sequence[pin.SE3], grasp: Grasp, tool: Tool, arms: list[int], works: Bools
    ) -> None:
        """Write which of the arms (p, a), which carry the same tool, can take the part."""
        turns = grips(self.cell.arms[arms[0]].tool, grasp)
        opening = grasp.opening if tool.fingers else 0.0
        fixed, travels = self._corners[tool.name]
        Ts_world_tcp = [T * grasp.T_part_tcp * turn for T in Ts for turn in turns]
        is_stuck = _stuck(
            np.array([T.rotation for T in Ts_world_tcp]),
            np.array([T.translation for T in Ts_world_tcp]),
            fixed + opening * travels,
            *self._boxes,
        )
        for number, T in enumerate(Ts_world_tcp):
            k = number // len(turns)
            left = [a for a in arms if not works[k, a]]
            if is_stuck[number] or not left or not self._fits(left[0], T, opening):
                continue
            reached = [a for a in left if self._reaches(a, T)]
            if reached and (not tool.fingers or self._fits(left[0], T, grasp.grip)):
                works[k, reached] = True

    def _reaches(self, a: int, T_world_tcp: pin.SE3) -> bool:
        """Whether the arm gets its tool there; the answer before is the first guess."""
        chain = self._chains[a]
        answers, residuals = chain.solve(T_world_tcp, self._last[a][None])
        found = answers[is_solution(residuals)]
        if not len(found):
            found = configurations(chain, T_world_tcp, self._starts[a]).q
        if not len(found):
            return False
        self._last[a] = found[0]
        return True

    def _fits(self, a: int, T_world_tcp: pin.SE3, opening: float) -> bool:
        """Whether the tool alone is clear of bin and fixtures."""
        arm = self.cell.arms[a]
        return self._check.contact(arm, T_world_tcp, opening, NO_TARGET, 0.0) is None


def _boxes(surroundings: Surroundings) -> tuple[Floats, Floats, Floats]:
    """Rotations (b, 3, 3), centres (b, 3) and half sizes (b, 3) of what stands still in boxes."""
    found = [
        (body.T_joint_body, np.asarray(body.shape.size) / 2)
        for body in surroundings.bodies
        if isinstance(body.shape, Box)
    ]
    return (
        np.array([T.rotation for T, _ in found]),
        np.array([T.translation for T, _ in found]),
        np.array([half for _, half in found]),
    )


def _corners(tool: Tool) -> tuple[Floats, Floats]:
    """Points (k, 3) [m] of the tool in the TCP frame, and how each goes for a metre of opening."""
    T_tcp_flange = tool.T_flange_tcp.inverse()
    solids = [(solid, np.zeros(3)) for solid in tool.body]
    solids += [(finger.solid, np.asarray(finger.direction) / 2) for finger in tool.fingers]
    points, travels = [], []
    for solid, travel in solids:
        T = T_tcp_flange * solid.T_owner_shape
        corners = outline(solid.shape) @ T.rotation.T + T.translation
        points.append(corners)
        travels.append(np.tile(T_tcp_flange.rotation @ travel, (len(corners), 1)))
    return np.vstack(points), np.vstack(travels)


@njit(cache=True)
def _stuck(
    R: Floats, p: Floats, corners: Floats, boxes: Floats, centres: Floats, halves: Floats
) -> Bools:
    """At which poses (n,) a corner lies in a box: most that do not fit are found so, at once."""
    found = np.zeros(len(R), np.bool_)
    x = np.empty(3)
    for n in range(len(R)):
        for k in range(len(corners)):
            for i in range(3):
                x[i] = p[n, i]
                for m in range(3):
                    x[i] += R[n, i, m] * corners[k, m]
            for b in range(len(boxes)):
                inside = True
                for i in range(3):
                    local = 0.0
                    for m in range(3):
                        local += boxes[b, m, i] * (x[m] - centres[b, m])
                    if abs(local) > halves[b, i]:
                        inside = False
                        break
                if inside:
                    found[n] = True
                    break
            if found[n]:
                break
    return found


def _starts(chain: Chain, arm: Arm) -> Floats:
    """Home, the middle of the range, and random configurations, the same every time."""
    rng = np.random.default_rng(0)
    random = rng.uniform(chain.lower, chain.upper, (IK_STARTS - 2, len(chain.lower)))
    return np.vstack([arm.home, (chain.lower + chain.upper) / 2, random])

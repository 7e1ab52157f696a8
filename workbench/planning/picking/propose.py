"""Every detection with every grasp and every arm, and the cheap tests that refuse most of them."""

import coal
import numpy as np
import pinocchio as pin

from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.model.part import Grasp
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.bodies import coal_shape, extent, still_bodies
from workbench.planning.collision.legs import grips
from workbench.planning.kinematics.chain import chain_of

TURN_WEIGHT = 0.1
"""[m/rad] What a turn of the hand counts against its way in the SE(3) index."""


class ToolCheck:
    """The tool alone, floating in the bin: no arm, so no inverse kinematics is needed.

    Lifetime: as long as cell and detections.
    """

    def __init__(
        self,
        cell: Cell,
        detections: tuple[Detection, ...],
        obstacles: tuple[Obstacle, ...] = (),
    ):
        self._margin = cell.policy.near_margin
        # The bin first: where the tool meets several things, that one is named.
        still = sorted(
            still_bodies(cell, detections, obstacles), key=lambda body: body.kind != "bin"
        )
        self._labels = [body.label for body in still]
        self._numbers = np.array([int(b.owner) if b.kind == "part" else -1 for b in still])
        self._shapes = [coal_shape(body.shape) for body in still]
        poses = [body.T_joint_body for body in still]
        extents = [extent(body.shape) for body in still]
        self._transforms = [coal.Transform3s(T.rotation, T.translation) for T in poses]
        self._R = np.array([T.rotation for T in poses])
        self._centres = np.array([T.act(e[0]) for T, e in zip(poses, extents, strict=True)])
        self._halves = np.array([half for _, half, _ in extents])
        self._request = coal.DistanceRequest()
        self._tools = {arm.name: _tool_shapes(arm) for arm in cell.arms}

    def contact(
        self, arm: Arm, T_world_tcp: pin.SE3, opening: float, target: int, press: float
    ) -> tuple[tuple[str, str], float] | None:
        """The first obstacle closer to the tool than its margin, and its distance [m].

        The part to be taken has no margin; the tool may cut into it by `press` [m].
        """
        T_world_flange = T_world_tcp * arm.tool.T_flange_tcp.inverse()
        result = coal.DistanceResult()
        for name, shape, T_flange_body, direction, centre, radius in self._tools[arm.name]:
            T = T_world_flange * pin.SE3(
                T_flange_body.rotation, T_flange_body.translation + direction * opening / 2
            )
            transform = coal.Transform3s(T.rotation, T.translation)
            offset = np.einsum("gji,gj->gi", self._R, T.act(centre) - self._centres)
            gap = np.linalg.norm(np.maximum(np.abs(offset) - self._halves, 0.0), axis=1) - radius
            for g in np.flatnonzero(gap < self._margin):
                margin = -press if self._numbers[g] == target else self._margin
                result.clear()
                distance = coal.distance(
                    shape, transform, self._shapes[g], self._transforms[g], self._request, result
                )
                if distance < margin:
                    return (f"{arm.name} {name}", self._labels[g]), float(distance)
        return None


def _tool_shapes(
    arm: Arm,
) -> list[tuple[str, coal.CollisionGeometry, pin.SE3, Floats, Floats, float]]:
    """Name, shape, `T_flange_body`, finger direction, centre and radius of each tool solid."""
    moving = [(finger.solid, np.asarray(finger.direction)) for finger in arm.tool.fingers]
    fixed = [(solid, np.zeros(3)) for solid in arm.tool.body]
    shapes = []
    for solid, direction in fixed + moving:
        centre, _, radius = extent(solid.shape)
        shapes.append(
            (solid.name, coal_shape(solid.shape), solid.T_owner_shape, direction, centre, radius)
        )
    return shapes


def propose(
    cell: Cell, detections: tuple[Detection, ...], obstacles: tuple[Obstacle, ...] = ()
) -> tuple[Candidate, ...]:
    """All candidates, refused ones included, in the order in which they shall be tried.

    The order: admitted ones first, then priority, then the SE(3) index, which is the way of
    the TCP from home to the grasp plus `TURN_WEIGHT` times its turn.
    """
    check = ToolCheck(cell, detections, obstacles)
    homes = {arm.name: chain_of(cell, arm).pose(np.asarray(arm.home)) for arm in cell.arms}
    candidates = [
        candidate_of(check, number, detection, grasp, arm, homes[arm.name])
        for number, detection in enumerate(detections)
        for grasp in cell.part(detection.part).grasps
        for arm in cell.arms
    ]
    return tuple(
        sorted(
            candidates,
            key=lambda c: (not c.verdict.is_ok, -c.grasp.priority, c.rank),
        )
    )


def candidate_of(
    check: ToolCheck,
    number: int,
    detection: Detection,
    grasp: Grasp,
    arm: Arm,
    T_world_home: pin.SE3,
) -> Candidate:
    """One candidate with its first verdict; `T_world_home` is where the TCP is at home."""
    T_world_tcp = detection.T_world_part * grasp.T_part_tcp
    T_home_tcp = T_world_home.actInv(T_world_tcp)
    way = float(np.linalg.norm(T_home_tcp.translation))
    turn = float(np.linalg.norm(pin.log3(T_home_tcp.rotation)))
    verdict = _first_verdict(check, number, grasp, arm, T_world_tcp)
    return Candidate(number, grasp, arm.name, T_world_tcp, way + TURN_WEIGHT * turn, verdict)


def _first_verdict(
    check: ToolCheck, number: int, grasp: Grasp, arm: Arm, T_world_tcp: pin.SE3
) -> Verdict:
    if not grasp.is_enabled:
        return Verdict(Reason.DISABLED, Stage.PROPOSE)
    if grasp.arms and arm.name not in grasp.arms:
        return Verdict(Reason.ARM_NOT_ALLOWED, Stage.PROPOSE, note=f"only {', '.join(grasp.arms)}")
    if grasp.tool and grasp.tool != arm.tool.name:
        can = "can carry it" if grasp.tool in {one.name for one in arm.tools} else "cannot"
        note = f"is for {grasp.tool}; the arm carries {arm.tool.name} and {can}"
        return Verdict(Reason.ARM_NOT_ALLOWED, Stage.PROPOSE, note=note)
    low, high = arm.tool.stroke
    if arm.tool.fingers and not low <= grasp.opening <= high:
        return Verdict(
            Reason.TOOL_COLLISION,
            Stage.PROPOSE,
            note=f"opening {grasp.opening * 1e3:.0f} mm is outside the stroke "
            f"{low * 1e3:.0f}-{high * 1e3:.0f} mm",
        )
    refusal: Verdict | None = None
    for T_tcp_hand in grips(arm, grasp):
        verdict = _tool_verdict(check, number, grasp, arm, T_world_tcp * T_tcp_hand)
        if verdict.is_ok:
            return verdict
        refusal = refusal or verdict
    return refusal or Verdict(Reason.OK, Stage.PROPOSE)


def _tool_verdict(
    check: ToolCheck, number: int, grasp: Grasp, arm: Arm, T_world_tcp: pin.SE3
) -> Verdict:
    """Whether the tool fits there, with the fingers as on arrival and as closed."""
    press = arm.tool.press
    ways = ((grasp.opening, 0.0), (grasp.grip, press)) if arm.tool.fingers else ((0.0, press),)
    for opening, press in ways:
        found = check.contact(arm, T_world_tcp, opening, number, press)
        if found is not None:
            note = f"fingers {opening * 1e3:.0f} mm apart" if arm.tool.fingers else ""
            return Verdict(
                Reason.TOOL_COLLISION, Stage.PROPOSE, pair=found[0], distance=found[1], note=note
            )
    return Verdict(Reason.OK, Stage.PROPOSE)

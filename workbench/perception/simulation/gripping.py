"""A part that two fingers close on, lift and shake: how it lies in the hand then.

The part lies at rest on a plane; nothing else is there.  The hand stands still: the plane goes away
instead of the hand, and what the hand's motion does to the part is added to gravity.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
import pinocchio as pin

from workbench.model.cell import Tool
from workbench.model.geometry import Box, Floats, Mesh, Solid, copy_pose, finest, put
from workbench.model.part import Part
from workbench.perception.simulation.physics import add_solid
from workbench.perception.views.surfaces import triangles_of

TIME_STEP = 0.001
"""[s] Of simulated time."""

CLOSING = 0.02
"""[m/s] Of each finger, before it meets something."""

FINGER_MASS = 0.1
"""[kg]"""

TILE = 0.003
"""[m] For what is round pads are cut into tiles of about this size.  MuJoCo has a box and a
cylinder touch at one point, and not along a line.  Flat things touch the whole box."""

ON_PLANE, ON_PAD, ON_TILES = 1, 2, 4
"""Bits of what touches what."""

PAD, PLANE = (0.4, 0.001, 0.0), (0.4, 0.002, 0.0005)
"""Friction of pads and of what the part lies on, no unit; that against turning about the normal
[m], as soft pads have it; and against rolling [m]."""

CLOSES_WITHIN, STILL_SPEED = 2.0, 1e-3
"""[s] In which the fingers have to close; [m/s] they have when they move no more."""

SETTLE, SHAKE = 0.1, 0.1
"""[s] The hand holds on before it moves, and accelerates each way for that long."""

GRAVITY = 9.81
"""[m/s2]"""

WHILE, ASIDE = 0.5, np.array([0.0, 0.0, 5.0])
"""[s] A part that leans on something falls within this; [m] where the hand is meanwhile."""

NO_SLIP = 10
"""Iterations of MuJoCo's search for forces without slip."""


@dataclass(frozen=True, slots=True, eq=False)
class Shaking:
    """What a hand does to a part: the `force` [N] of each finger and `acceleration` [m/s2]."""

    force: float
    acceleration: float


@dataclass(frozen=True, slots=True, eq=False)
class HeldPart:
    """A part in the hand once it is closed, `T_tcp_closed`, and at the end, `T_tcp_part`.

    Both are None where the fingers came down on the part, or met nothing that they could hold.
    """

    T_tcp_closed: pin.SE3 | None = None
    T_tcp_part: pin.SE3 | None = None

    def __post_init__(self) -> None:
        for name in ("T_tcp_closed", "T_tcp_part"):
            T = getattr(self, name)
            put(self, **{name: None if T is None else copy_pose(T)})

    @property
    def slip(self) -> tuple[float, float] | None:
        """How far the part has slipped [m] and turned [rad] in the hand since it was closed."""
        if self.T_tcp_closed is None or self.T_tcp_part is None:
            return None
        T = self.T_tcp_closed.actInv(self.T_tcp_part)
        return float(np.linalg.norm(T.translation)), float(np.linalg.norm(pin.log3(T.rotation)))


def world_of_grips() -> mujoco.MjSpec:
    """An empty world, computed so that what fingers press on does not creep."""
    spec = mujoco.MjSpec()
    spec.option.timestep = TIME_STEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    spec.option.noslip_iterations = NO_SLIP
    return spec


def close_alike(spec: mujoco.MjSpec) -> None:
    """Have both fingers, on the joints `slide0` and `slide1`, always be as far closed."""
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT,
        name1="slide1",
        name2="slide0",
        data=[0.0, 1.0, *[0.0] * 10],
        solref=[2 * TIME_STEP, 1.0],
    )


class Gripping:
    """A part at rest and a tool with two fingers, to be gripped again and again.

    Lifetime: as long as both.  Concurrency: one thread at a time.
    """

    def __init__(self, part: Part, tool: Tool, T_world_part: pin.SE3):
        """The part lies there, on a plane under its lowest point."""
        self._T_flange_tcp, self._stroke = tool.T_flange_tcp, tool.stroke
        self._T_world_part = T_world_part
        spec = world_of_grips()
        body = spec.worldbody.add_body(name="part")
        body.add_freejoint()
        for piece in finest(part.pieces):
            geom = add_solid(spec, body, piece)
            is_flat = isinstance(piece.shape, Box | Mesh)
            geom.contype, geom.conaffinity = 0, ON_PLANE + (ON_PAD if is_flat else ON_TILES)
            geom.condim, geom.friction = 4, PAD
        low = min(float((_points(piece) @ T_world_part.rotation[2]).min()) for piece in part.pieces)
        floor = spec.worldbody.add_geom(
            name="floor",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[1, 1, 0.1],
            pos=[0, 0, T_world_part.translation[2] + low],
            friction=PLANE,
            condim=6,
        )
        floor.contype, floor.conaffinity = ON_PLANE, 0
        hand = spec.worldbody.add_body(name="hand")
        for number, finger in enumerate(tool.fingers):
            moved = hand.add_body(name=f"finger{number}")
            moved.add_joint(
                name=f"slide{number}",
                type=mujoco.mjtJoint.mjJNT_SLIDE,
                axis=finger.direction,
            )
            pads = [(tile, ON_TILES) for tile in tiles(finger.solid, finger.direction)]
            for solid, kind in [(finger.solid, ON_PAD), *pads]:
                geom = add_solid(spec, moved, solid)
                geom.contype, geom.conaffinity, geom.condim, geom.friction = kind, 0, 4, PAD
            moved.explicitinertial = True
            moved.mass, moved.inertia = FINGER_MASS, [1e-4, 1e-4, 1e-4]
            moved.gravcomp = 1.0
        close_alike(spec)
        self._model = model = spec.compile()
        self._part = model.body("part").id
        self._hand = model.body("hand").id
        self._floor = model.geom("floor").id
        model.body_inertia[self._part] *= part.mass / model.body_mass[self._part]
        model.body_mass[self._part] = part.mass
        mujoco.mj_setConst(model, mujoco.MjData(model))

    def settled(self) -> pin.SE3:
        """`T_world_part` after a while in which nobody touches it: what leans on things falls."""
        data = self._at_start(pin.SE3(np.eye(3), self._T_world_part.translation + ASIDE))
        mujoco.mj_step(self._model, data, nstep=round(WHILE / TIME_STEP))
        return pose_of(data)

    def grip(self, T_world_tcp: pin.SE3, opening: float, shaking: Shaking) -> HeldPart:
        """Close fingers that are open by `opening` [m] at a pose of the hand, lift and shake."""
        model = self._model
        data = self._at_start(T_world_tcp * self._T_flange_tcp.inverse())
        data.qpos[7:] = opening / 2
        mujoco.mj_forward(model, data)
        if self._touches(data):
            return HeldPart()
        model.dof_damping[6:] = shaking.force / CLOSING
        data.qfrc_applied[6:] = -shaking.force
        for _ in range(round(CLOSES_WITHIN / TIME_STEP / 10)):
            mujoco.mj_step(model, data, nstep=10)
            if np.abs(data.qvel[6:]).max() < STILL_SPEED and self._touches(data):
                break
        mujoco.mj_step(model, data, nstep=round(SETTLE / TIME_STEP))
        closed = T_world_tcp.actInv(pose_of(data))
        if not self._touches(data):
            return HeldPart()
        # The plane goes, and the hand accelerates upwards and to all sides.
        model.geom_contype[self._floor] = 0
        a = shaking.acceleration
        for way in ((0, 0, a), (a, 0, 0), (-a, 0, 0), (0, a, 0), (0, -a, 0), (0, 0, 0)):
            model.opt.gravity[:] = -np.array(way, float) - (0.0, 0.0, GRAVITY)
            mujoco.mj_step(model, data, nstep=round(SHAKE / TIME_STEP))
        return HeldPart(closed, T_world_tcp.actInv(pose_of(data)))

    def _touches(self, data: mujoco.MjData) -> bool:
        """Whether a finger is in touch with the part."""
        bodies = self._model.geom_bodyid[data.contact.geom]
        return bool(((bodies == self._part).any(axis=1) & (bodies > self._hand).any(axis=1)).any())

    def _at_start(self, T_world_hand: pin.SE3) -> mujoco.MjData:
        """The part on the plane, and the hand there."""
        model = self._model
        model.body_pos[self._hand] = T_world_hand.translation
        model.body_quat[self._hand] = quaternion_of(T_world_hand)
        model.opt.gravity[:] = (0.0, 0.0, -GRAVITY)
        model.geom_contype[self._floor] = ON_PLANE
        data = mujoco.MjData(model)
        data.qpos[:7] = [*self._T_world_part.translation, *quaternion_of(self._T_world_part)]
        return data


def pose_of(data: mujoco.MjData) -> pin.SE3:
    """`T_world_part`."""
    x, y, z, w, i, j, k = data.qpos[:7]
    return pin.SE3(pin.Quaternion(w, i, j, k).normalized().matrix(), np.array([x, y, z]))


def tiles(solid: Solid, direction: Floats, tile: float = TILE) -> list[Solid]:
    """A box cut across the way of its finger (3,), no unit, into tiles of about `tile` [m].

    Another shape is left whole.
    """
    if not isinstance(solid.shape, Box):
        return [solid]
    T, size = solid.T_owner_shape, np.array(solid.shape.size)
    thick = int(np.argmax(np.abs(T.rotation.T @ direction)))
    counts = np.maximum(np.round(size / tile), 1).astype(int)
    counts[thick] = 1
    shape = Box(size / counts)
    return [
        Solid(
            f"{solid.name}{place}",
            shape,
            T * pin.SE3(np.eye(3), ((np.array(place) + 0.5) / counts - 0.5) * size),
        )
        for place in np.ndindex(*counts)
    ]


def _points(piece: Solid) -> Floats:
    """Points (n, 3) [m] on the surface of a piece, in the part's frame."""
    T, points = piece.T_owner_shape, np.asarray(triangles_of(piece.shape).vertices)
    return points @ T.rotation.T + T.translation


def quaternion_of(T: pin.SE3) -> Floats:
    """w, x, y, z (4,), no unit, as MuJoCo has them."""
    q = pin.Quaternion(T.rotation)
    return np.array([q.w, q.x, q.y, q.z])

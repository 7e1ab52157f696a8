"""A part that fingers or a cup hold, pulled in one direction after another: whether it stays.

Nothing else is there: the part floats between the fingers until they have closed, and weight and
acceleration are one pull.  Every shape is met by pads that are cut into tiles, and a cup is a ring
of beads that the part is drawn to.
"""

import copy
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import pinocchio as pin

from workbench.model.cell import Tool
from workbench.model.geometry import Floats, Solid, Sphere, finest, shift_and_turn
from workbench.model.part import Part
from workbench.perception.simulation.gripping import (
    CLOSES_WITHIN,
    CLOSING,
    FINGER_MASS,
    STILL_SPEED,
    TIME_STEP,
    close_alike,
    pose_of,
    quaternion_of,
    tiles,
    world_of_grips,
)
from workbench.perception.simulation.physics import add_solid

TILE = 0.005
"""[m] Of pads."""

BEADS, BEAD = 16, 0.001
"""Around a cup's lip, and [m] their radius."""

GAP_A_FINGER = 0.0005
"""[m] Of each finger before it closes."""

RISES, PULLS = 0.02, 0.13
"""[s] In which a pull grows, and how long it lasts then."""

FREELY = 0.02
"""Share of the damping by which fingers closed that is left while the part is pulled."""

SLIPS, TIPS = 0.001, float(np.deg2rad(2.0))
"""Motion [m] in the hand from which on a part slips, and rotation [rad] from which on it tips."""


@dataclass(frozen=True, slots=True)
class GripForce:
    """The `force` [N] of each finger or of the vacuum, `friction`, no unit, `lip` [m]: a cup's."""

    force: float
    friction: float
    lip: float = 0.0


class Pulling:
    """A part in a hand.  Lifetime: as long as both.  Concurrency: one thread at a time."""

    def __init__(
        self, part: Part, tool: Tool, T_tcp_part: pin.SE3, centre: Floats, grip: GripForce
    ):
        """The part lies so, its centre of mass (3,) [m] there in its own frame."""
        self._grip, self._T_tcp_part = grip, T_tcp_part
        self._fingers = len(tool.fingers)
        spec = world_of_grips()
        body = spec.worldbody.add_body(name="part")
        body.add_freejoint()
        for piece in finest(part.pieces):
            _rub(add_solid(spec, body, piece), grip.friction, contype=0, conaffinity=1)
        hand = spec.worldbody.add_body(name="hand")
        for number, finger in enumerate(tool.fingers):
            moved = hand.add_body(name=f"finger{number}", gravcomp=1.0)
            moved.add_joint(
                name=f"slide{number}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=finger.direction
            )
            for solid in tiles(finger.solid, finger.direction, TILE):
                _rub(add_solid(spec, moved, solid), grip.friction, contype=1, conaffinity=0)
            moved.explicitinertial = True
            moved.mass, moved.inertia = FINGER_MASS, [1e-4, 1e-4, 1e-4]
        if tool.fingers:
            close_alike(spec)
        else:
            lip = spec.worldbody.add_body(name="lip")
            for bead in _beads(grip.lip):
                _rub(add_solid(spec, lip, bead), grip.friction, contype=1, conaffinity=0)
        self._model = model = spec.compile()
        self._part, carried = model.body("part").id, model.body("hand").id
        T_tcp_flange = tool.T_flange_tcp.inverse()
        model.body_pos[carried] = T_tcp_flange.translation
        model.body_quat[carried] = quaternion_of(T_tcp_flange)
        model.body_inertia[self._part] *= part.mass / model.body_mass[self._part]
        model.body_mass[self._part] = part.mass
        # Pieces may overlap: they say how the mass is spread, but not where its middle is.
        model.body_ipos[self._part] = centre
        mujoco.mj_setConst(model, mujoco.MjData(model))

    def stays(self, width: float, pulls: Sequence[Floats]) -> bool | None:
        """Whether the part stays as the hand took it, whatever pulls.

        Args:
            width: [m] of the part between the fingers.
            pulls: each an acceleration (3,) [m/s2] along the TCP's axes; tried by itself.

        Returns:
            None where the hand holds nothing, or has pushed the part elsewhere as it closed.
        """
        data = self._close(width)
        if data is None:
            return None
        taken = pose_of(data)
        for pull in pulls:
            far, turn = shift_and_turn(taken.actInv(pose_of(self._pull(data, pull))))
            if far > SLIPS or turn > TIPS:
                return False
        return True

    def _close(self, width: float) -> mujoco.MjData | None:
        """The part in the closed hand, still with nothing that pulls."""
        model, grip = self._model, self._grip
        model.opt.gravity[:] = 0.0
        data = mujoco.MjData(model)
        data.qpos[:7] = [*self._T_tcp_part.translation, *quaternion_of(self._T_tcp_part)]
        data.qpos[7:] = width / 2 + GAP_A_FINGER
        model.dof_damping[6:] = grip.force / CLOSING
        data.qfrc_applied[6:] = -grip.force
        for _ in range(round(CLOSES_WITHIN / TIME_STEP / 10)):
            self._step(data, 10)
            if np.abs(data.qvel).max() < STILL_SPEED and len(data.contact.geom):
                break
        model.dof_damping[6:] *= FREELY
        self._step(data, round(RISES / TIME_STEP))
        far, turn = shift_and_turn(self._T_tcp_part.actInv(pose_of(data)))
        return data if len(data.contact.geom) and far <= SLIPS and turn <= TIPS else None

    def _pull(self, data: mujoco.MjData, pull: Floats) -> mujoco.MjData:
        data, steps = copy.copy(data), round(RISES / TIME_STEP)
        for k in range(steps):
            self._model.opt.gravity[:] = pull * (k + 1) / steps
            self._step(data, 1)
        self._step(data, round(PULLS / TIME_STEP))
        self._model.opt.gravity[:] = 0.0
        return data

    def _step(self, data: mujoco.MjData, count: int) -> None:
        """Let time pass; a cup draws the part along its axis, at its middle."""
        for _ in range(1 if self._fingers else count):
            if not self._fingers:
                force = np.array([0.0, 0.0, -self._grip.force])
                data.xfrc_applied[self._part, :3] = force
                data.xfrc_applied[self._part, 3:] = np.cross(-data.xipos[self._part], force)
            mujoco.mj_step(self._model, data, nstep=count if self._fingers else 1)


def _rub(geom: mujoco.MjsGeom, friction: float, *, contype: int, conaffinity: int) -> None:
    """Friction against sliding alone: what holds against turning is the extent of the pads."""
    geom.friction, geom.condim = [friction, 0.0, 0.0], 3
    geom.contype, geom.conaffinity = contype, conaffinity


def _beads(radius: float) -> list[Solid]:
    """A ring of beads that ends at the TCP's plane."""
    turns = np.arange(BEADS) * 2 * np.pi / BEADS
    places = radius * np.column_stack([np.cos(turns), np.sin(turns), np.zeros(BEADS)])
    return [
        Solid(f"bead{k}", Sphere(BEAD), pin.SE3(np.eye(3), place - [0.0, 0.0, BEAD]))
        for k, place in enumerate(places)
    ]

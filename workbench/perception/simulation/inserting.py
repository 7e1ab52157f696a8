"""A part that is inserted into another one by a hand that gives way sideways: whether it mates.

The parts consist of their joint alone: a peg, and a hole of flat segments with a chamfer of 45
degrees.  The base stands still.  The hand moves straight, as fast as it likes until it has to push
harder than it may, and does not turn.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
import pinocchio as pin

from workbench.model.geometry import Box, Cylinder, Solid
from workbench.model.recipes.joint import Joint
from workbench.model.recipes.kit import Insertion
from workbench.perception.simulation.gripping import quaternion_of, world_of_grips
from workbench.perception.simulation.physics import add_solid

TIME_STEP = 0.0005
"""[s] Of simulated time."""

SPEED, SETTLE = 0.02, 0.1
"""[m/s] Of the hand; [s] it pushes at the end."""

LEAD, SHORT = 0.002, 0.0005
"""[m] The hand begins this far before the parts meet; what ends nearer to its seat is seated."""

SEGMENTS, WALL = 64, 0.004
"""Around a hole; [m] how thick each is."""

RELIEF = 0.00002
"""[m] A bore is wider than its mouth by this.  MuJoCo lets bodies overlap a little, so a part that
slides over the edge would catch on the box behind."""

HAND_MASS, PART_MASS = 1.0, 0.1
"""[kg]"""

SERVO = 2e5
"""[N/m] Stiffness of the hand's motion."""


@dataclass(frozen=True, slots=True)
class Push:
    """How a hand inserts: with at most `force` [N], `friction` between the parts, no unit.

    It gives way sideways by a spring of `stiffness` [N/m].
    """

    force: float
    friction: float
    stiffness: float


@dataclass(frozen=True, slots=True)
class Inserted:
    """How far the part is from its seat at last, and how far it was pushed sideways at most [m]."""

    left: float
    pushed: float

    def is_mated(self, joint: Joint) -> bool:
        """Whether it is seated, and the hand has given way no farther than it does."""
        return self.left <= SHORT and self.pushed <= joint.compliance + SHORT / 10


class Inserting:
    """A joint in which a part is inserted again and again, each time differently off.

    Lifetime: as long as wanted.  Concurrency: one thread at a time.
    """

    def __init__(self, insertion: Insertion, radius: float, push: Push, *, is_peg: bool):
        """The `radius` [m] is that of the peg; the part is that, or the hole that goes over it."""
        joint = insertion.joint
        assert joint is not None
        self._joint, self._T_base_part = joint, insertion.T_base_part
        self._along = np.array(insertion.along)
        R = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), self._along).matrix()
        T_base_joint = pin.SE3(R, np.array(joint.mouth))
        spec = world_of_grips()
        spec.option.timestep = TIME_STEP
        spec.option.gravity = np.zeros(3)
        base = spec.worldbody.add_body(name="base")
        hand = spec.worldbody.add_body(name="hand")
        hand.add_joint(name="forward", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=self._along)
        _weigh(hand, HAND_MASS)
        wrist = hand.add_body(name="wrist")
        if joint.compliance > 0:
            for name, axis in zip(("x", "y"), R.T[:2], strict=True):
                wrist.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        _weigh(wrist, PART_MASS)
        part = wrist.add_body(name="part")
        _weigh(part, PART_MASS / 100)
        of_base, of_part = (_hole, _peg) if is_peg else (_peg, _hole)
        T_part_joint = self._T_base_part.actInv(T_base_joint)
        behind = joint.depth - joint.part_length
        solids = [
            *((base, it) for it in of_base(joint, radius, T_base_joint, 0.0, joint.base_length, 1)),
            *((part, it) for it in of_part(joint, radius, T_part_joint, behind, joint.depth, -1)),
        ]
        for body, solid in solids:
            geom = add_solid(spec, body, solid)
            geom.condim, geom.friction = 3, [push.friction, 0.0, 0.0]
            geom.solref, geom.solimp = [2 * TIME_STEP, 1.0], [0.99, 0.999, 1e-4, 0.5, 2.0]
            geom.contype = geom.conaffinity = 1
        _drive(spec, push.force)
        self._model = model = spec.compile()
        model.jnt_stiffness[1:] = push.stiffness
        model.dof_damping[1:] = 4 * np.sqrt(push.stiffness * PART_MASS)

    def insert(self, T_base_off: pin.SE3, T_part_off: pin.SE3) -> Inserted:
        """Insert a part, itself and its base off by these motions in their own frames."""
        model, joint = self._model, self._joint
        T_base_part = self._T_base_part * T_part_off
        for name, T in (("base", T_base_off), ("part", T_base_part)):
            body = model.body(name).id
            model.body_pos[body], model.body_quat[body] = T.translation, quaternion_of(T)
        data = mujoco.MjData(model)
        data.qpos[0] = start = -(joint.depth + joint.chamfer + LEAD)
        pushed, every = 0.0, 20
        for k in range(round((-start / SPEED + SETTLE) / TIME_STEP / every)):
            data.ctrl[0] = min(start + SPEED * k * every * TIME_STEP, 0.0)
            mujoco.mj_step(model, data, nstep=every)
            pushed = max(pushed, float(np.linalg.norm(data.qpos[1:])))
        return Inserted(-float(data.qpos[0]), pushed)


def _drive(spec: mujoco.MjSpec, force: float) -> None:
    """Move the joint `forward` to its target, with at most a force [N]."""
    spec.add_actuator(
        name="forward",
        target="forward",
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        gainprm=[SERVO, *[0.0] * 9],
        biasprm=[0.0, -SERVO, -2 * np.sqrt(SERVO * HAND_MASS), *[0.0] * 7],
        forcerange=[-force, force],
        forcelimited=True,
    )


def _weigh(body: mujoco.MjsBody, mass: float) -> None:
    body.explicitinertial = True
    body.mass, body.inertia = mass, [1e-3 * mass] * 3


def _peg(
    joint: Joint, radius: float, T: pin.SE3, low: float, high: float, mouth: int
) -> list[Solid]:
    """A cylinder between two depths [m] of the joint's frame `T`."""
    middle = pin.SE3(np.eye(3), np.array([0.0, 0.0, (low + high) / 2]))
    return [Solid("peg", Cylinder(radius, high - low), T * middle)]


def _hole(
    joint: Joint, radius: float, T: pin.SE3, low: float, high: float, mouth: int
) -> list[Solid]:
    """Boxes around a bore between two depths, and slanted ones before its mouth.

    Its mouth is at the lower depth, 1, or at the higher one, -1.
    """
    inner = radius + joint.clearance
    wide = inner + RELIEF
    width = 2 * (inner + joint.chamfer + 2 * WALL) * np.tan(np.pi / SEGMENTS)
    bore = pin.SE3(np.eye(3), np.array([wide + WALL / 2, 0.0, (low + high) / 2]))
    forms = [(Box(np.array([WALL, width, high - low])), bore)]
    if joint.chamfer > 0:
        edge, half = np.array([inner, 0.0, low if mouth > 0 else high]), joint.chamfer / 2
        slant = pin.SE3(pin.rpy.rpyToMatrix(0.0, -mouth * np.pi / 4, 0.0), np.zeros(3))
        middle = edge + np.array([half, 0.0, -mouth * half])
        slant.translation = middle + slant.rotation @ np.array([WALL / 2, 0.0, 0.0])
        forms.append((Box(np.array([WALL, width, joint.chamfer * np.sqrt(2)])), slant))
    turns = (
        pin.SE3(pin.exp3(np.array([0.0, 0.0, 2 * np.pi * k / SEGMENTS])), np.zeros(3))
        for k in range(SEGMENTS)
    )
    return [
        Solid(f"segment{k}{number}", shape, T * turn * where)
        for k, turn in enumerate(turns)
        for number, (shape, where) in enumerate(forms)
    ]

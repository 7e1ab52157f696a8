"""The cell's robot as one Pinocchio model: where every link is for given joint values."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats, Ints
from workbench.model.robot import Joint

AXIS_LETTERS = {(1.0, 0.0, 0.0): "X", (0.0, 1.0, 0.0): "Y", (0.0, 0.0, 1.0): "Z"}


class JointTree(NamedTuple):
    """The joints as arrays for compiled code, joint 0 being the world.

    `parents` (j,) the joint before each; `R` (j, 3, 3) and `p` (j, 3) [m] the fixed transform
    before it; `axes` (j, 3); `slides` (j,) 1.0 for prismatic joints.
    """

    parents: Ints
    R: Floats
    p: Floats
    axes: Floats
    slides: Floats


class Kinematics:
    """Forward kinematics of all arms of a cell.

    Lifetime: as long as the cell; holds no scene.
    Concurrency: one thread at a time, since Pinocchio's data is a scratch pad.
    """

    def __init__(self, cell: Cell):
        self.cell = cell
        self.model, self.frames = _build_model(cell)
        self.data = self.model.createData()
        self.axes: list[Floats | None] = [None] * self.model.njoints
        for joint in cell.robot.joints:
            if joint.kind == "revolute":
                self.axes[self.model.getJointId(joint.name)] = joint.axis
        self.tree = _tree(self.model, cell)
        self.columns = {
            arm.name: np.array([self.column(joint) for joint in arm.joints]) for arm in cell.arms
        }
        self.q_home = pin.neutral(self.model)
        for arm in cell.arms:
            self.q_home[self.columns[arm.name]] = arm.home

    def column(self, joint: str) -> int:
        """The place of a joint's value in the model's configuration vector."""
        return int(self.model.joints[self.model.getJointId(joint)].idx_q)

    def configuration(self, q: Mapping[str, Floats]) -> Floats:
        """The whole configuration (nq,) [rad, m]: named arms at `q` (n,), the others at home."""
        whole = self.q_home.copy()
        for arm, values in q.items():
            whole[self.columns[arm]] = values
        return whole

    def link_poses(self, q: Mapping[str, float]) -> dict[str, pin.SE3]:
        """`T_world_link` of every link for values of named joints; others stand at home."""
        whole = self.q_home.copy()
        for joint, value in q.items():
            whole[self.column(joint)] = value
        pin.forwardKinematics(self.model, self.data, whole)
        return {
            link: self.data.oMi[joint] * T_joint_link
            for link, (joint, T_joint_link) in self.frames.items()
        }

    def tcp_pose(self, arm: Arm, q: Floats) -> pin.SE3:
        """`T_world_tcp` of one arm at `q` (n,) [rad]."""
        pin.forwardKinematics(self.model, self.data, self.configuration({arm.name: q}))
        joint, T_joint_flange = self.frames[arm.flange]
        return self.data.oMi[joint] * T_joint_flange * arm.tool.T_flange_tcp


def _tree(model: pin.Model, cell: Cell) -> JointTree:
    axes, slides = np.zeros((model.njoints, 3)), np.zeros(model.njoints)
    for joint in cell.robot.joints:
        if joint.kind != "fixed":
            number = model.getJointId(joint.name)
            axes[number] = joint.axis
            slides[number] = 1.0 if joint.kind == "prismatic" else 0.0
    return JointTree(
        np.array(list(model.parents)),
        np.array([T.rotation for T in model.jointPlacements]),
        np.array([T.translation for T in model.jointPlacements]),
        axes,
        slides,
    )


def _build_model(cell: Cell) -> tuple[pin.Model, dict[str, tuple[int, pin.SE3]]]:
    """The model, and for each link the joint that carries it with `T_joint_link`."""
    model = pin.Model()
    model.name = cell.robot.name
    frames: dict[str, tuple[int, pin.SE3]] = {cell.robot.root: (0, cell.T_world_robot)}
    for joint in cell.robot.joints:
        parent, T_parent_link = frames[joint.parent]
        T = T_parent_link * joint.T_parent_joint
        if joint.kind == "fixed":
            frames[joint.child] = (parent, T)
            continue
        ones = np.ones(1)
        number = model.addJoint(
            parent,
            _joint_model(joint),
            T,
            joint.name,
            ones * 1e3,
            ones * joint.velocity,
            ones * joint.lower,
            ones * joint.upper,
        )
        frames[joint.child] = (number, pin.SE3.Identity())
    return model, frames


def _joint_model(joint: Joint) -> pin.JointModel:
    axis = AXIS_LETTERS.get(tuple(joint.axis.tolist()))
    if joint.kind == "revolute":
        if axis is None:
            return pin.JointModelRevoluteUnaligned(np.array(joint.axis))
        return getattr(pin, f"JointModelR{axis}")()
    if axis is None:
        return pin.JointModelPrismaticUnaligned(np.array(joint.axis))
    return getattr(pin, f"JointModelP{axis}")()

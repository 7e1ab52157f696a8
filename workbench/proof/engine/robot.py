"""The cell's robot with its fingers as Pinocchio sees it: joints, what they carry, what moves what.

Fingers are prismatic joints here: they close and open as the arms move, and are proven alike.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Bools, Floats, Ints
from workbench.model.robot import Joint


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """A robot's joints, joint 0 being the world; a whole configuration `q` (nq,) has a value each.

    `joints` are those of `model` by their numbers, the world left out.  `frames` gives for every
    link the joint that carries it and `T_joint_link`.  `columns` (n,) are
    the places in `q` of an arm's joints, followed by those of its fingers.  `ancestors` (j, nq) is
    True where a value of `q` moves a joint; `before` (j,) is what carries a joint, `commons`
    (j, j) the last that carries both of two.  `rest` (nq,) has the arms at home, fingers closed.
    `data` is Pinocchio's scratch paper: one thread at a time.
    """

    model: pin.Model
    joints: dict[int, Joint]
    frames: dict[str, tuple[int, pin.SE3]]
    fingers: dict[str, tuple[int, ...]]
    columns: dict[str, Ints]
    ancestors: Bools
    before: Ints
    commons: Ints
    rest: Floats
    data: pin.Data

    def flange(self, arm: Arm) -> tuple[int, pin.SE3]:
        """The joint that carries an arm's flange, and `T_joint_flange`."""
        return self.frames[arm.flange]


def tree_of(cell: Cell) -> Tree:
    """The robot of a cell, in the world."""
    model = pin.Model()
    joints: dict[int, Joint] = {}
    frames: dict[str, tuple[int, pin.SE3]] = {cell.robot.root: (0, cell.T_world_robot)}
    for joint in cell.robot.joints:
        parent, T_parent_link = frames[joint.parent]
        T = T_parent_link * joint.T_parent_joint
        if joint.kind == "fixed":
            frames[joint.child] = (parent, T)
        else:
            frames[joint.child] = (_add_joint(model, joints, parent, T, joint), pin.SE3.Identity())
    fingers: dict[str, tuple[int, ...]] = {}
    for arm in cell.arms:
        parent, T_joint_flange = frames[arm.flange]
        fingers[arm.name] = tuple(
            _add_joint(
                model, joints, parent, T_joint_flange, _finger(arm, number, finger.direction)
            )
            for number, finger in enumerate(arm.tool.fingers)
        )
    columns = {
        arm.name: np.array(
            [
                int(model.joints[j].idx_q)
                for j in (*map(model.getJointId, arm.joints), *fingers[arm.name])
            ]
        )
        for arm in cell.arms
    }
    rest = pin.neutral(model)
    for arm in cell.arms:
        rest[columns[arm.name][: len(arm.joints)]] = arm.home
    return Tree(
        model, joints, frames, fingers, columns, *_relations(model), rest, model.createData()
    )


def _finger(arm: Arm, number: int, direction: Floats) -> Joint:
    return Joint(
        f"{arm.name} finger {number}",
        "prismatic",
        arm.flange,
        "",
        pin.SE3.Identity(),
        direction,
        0.0,
        arm.tool.stroke[1] / 2,
    )


def _add_joint(
    model: pin.Model, joints: dict[int, Joint], parent: int, T: pin.SE3, joint: Joint
) -> int:
    is_turning = joint.kind == "revolute"
    kind = pin.JointModelRevoluteUnaligned if is_turning else pin.JointModelPrismaticUnaligned
    ones = np.ones(1)
    number = model.addJoint(
        parent,
        kind(np.array(joint.axis)),
        T,
        joint.name,
        ones * 1e3,
        ones * joint.velocity,
        ones * joint.lower,
        ones * joint.upper,
    )
    joints[number] = joint
    return number


def _relations(model: pin.Model) -> tuple[Bools, Ints, Ints]:
    """What moves each joint, which joint is before it, and the last that carries both of two."""
    before = np.array(list(model.parents))
    values = np.zeros((model.njoints, model.nq), bool)
    commons = np.zeros((model.njoints, model.njoints), np.int64)
    for j in range(1, model.njoints):
        values[j] = values[before[j]]
        values[j, model.joints[j].idx_q] = True
        # What carries this one and one before it, carries that one before and its own carrier.
        commons[j, :j] = commons[:j, j] = commons[before[j], :j]
        commons[j, j] = j
    return values, before, commons

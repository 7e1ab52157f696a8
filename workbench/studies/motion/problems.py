"""Motion problems made ready: a cell each, with one arm, nothing in its hand, and the obstacles."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.formats.robots.motion_problems import MotionProblem, MotionSet
from workbench.model.cell import Arm, Cell, Fixture, Policy, ScannerMount, Tool
from workbench.model.geometry import Floats, Solid
from workbench.model.part import Bin
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.plugins.robot_link import controller_by, usual_link

ARM = "arm"


class _NoBin(Bin):
    """A cell without a bin."""

    @property
    def solids(self) -> tuple[Solid, ...]:
        return ()


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """A problem made ready: its world, the ends (n,) [rad] as they can be sent, what is wrong.

    `name` is that of its set, in which it is the `number`-th; `problem` is its own.  `invalid` says
    why nobody can solve it; it is empty where somebody may.
    """

    name: str
    robot: str
    number: int
    problem: str
    world: World
    start: Floats
    goal: Floats
    invalid: str


def _case_of(name: str, robot: str, number: int, problem: MotionProblem, policy: Policy) -> Case:
    """A problem of the set `name`, the `number`-th in it."""
    world = World(_cell_of(problem, policy), ())
    world.enter(LegPhase(frozenset({ARM})))
    chain = world.chains[ARM]
    limits = problem.robot.limits(problem.joints)[:2]
    invalid, ends = "", []
    for end, q in (("start", problem.start), ("goal", problem.goal)):
        # Rounding a joint at its limit must not carry it beyond.
        ends.append(np.clip(world.motion.rounded(q), chain.lower, chain.upper))
        if np.any(q < limits[0]) or np.any(q > limits[1]):
            invalid = invalid or f"its {end} is beyond the limits of a joint"
        contact = world.contact(world.configuration({ARM: ends[-1]}))
        if contact is not None:
            invalid = invalid or f"at its {end} {' and '.join(contact.pair)} touch"
    return Case(name, robot, number, problem.name, world, ends[0], ends[1], invalid)


def _cell_of(problem: MotionProblem, policy: Policy) -> Cell:
    robot, joints = problem.robot, problem.joints
    moving = tuple(range(len(joints)))
    identity = pin.SE3.Identity()
    arm = Arm(
        name=ARM,
        controller_id="A",
        flange=robot.joint(joints[-1]).child,
        joints=joints,
        axis_order=moving,
        axis_signs=(1,) * len(joints),
        home=problem.start,
        acceleration=np.ones(len(joints)),
        tool=Tool("none", identity, ()),
    )
    fixtures = (Fixture("obstacles", identity, problem.obstacles),)
    return Cell(
        name=problem.name,
        robot=robot,
        T_world_robot=identity,
        arms=(arm,),
        bin=_NoBin(identity, np.ones(3)),
        scanner=ScannerMount(identity),
        controller=controller_by(usual_link()),
        parts=(),
        fixtures=fixtures,
        policy=policy,
    )


def cases_of(sets: Sequence[MotionSet], policy: Policy) -> list[Case]:
    """All problems made ready, to be planned by that policy."""
    return [
        _case_of(motion_set.name, motion_set.robot, number, problem, policy)
        for motion_set in sets
        for number, problem in enumerate(motion_set.problems)
    ]

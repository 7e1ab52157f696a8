"""Two arms at once: whether they can meet on two legs, and plans in which both do the same.

Where arms do the same at the same time, for each of their legs these are tried in turn:

1. both ways as planned for each arm alone, when the arms cannot meet on them whatever their
   speeds (`find_arm_contact`);
2. the way of one arm searched anew around the whole way of the other, first that of the second
   (the thesis' master and slave);
3. one after the other;
4. both as one motion of all joints, run in step.

A plan without legs in step is safe at any speeds: arms wait for each other between steps only.
`weave` puts the legs of two arms into any order, in the first and the third of these ways.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from workbench.model.candidate import Pick, Reason, Stage, Verdict
from workbench.model.geometry import Floats
from workbench.model.messages.plans import leg_message
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.motion import LEG_NAMES
from workbench.model.plan import ArmPlan, Guarantee, Leg, LegName, Plan, Step, Strategy
from workbench.planning.collision.arm_sweeps import ArmContact, ArmSweep, first_contact, standing
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.legs import HOLDING, LEAVING, Run, lead_of, phase_of
from workbench.planning.collision.motion import Curves, bound_curves, chain_contact
from workbench.planning.collision.world import World
from workbench.planning.kinematics.quickness import pace_of
from workbench.planning.picking.leaving import along_placed
from workbench.planning.picking.order import Cost
from workbench.planning.picking.route import (
    MOTIONS,
    arm_plan,
    hand_of,
    keep_upright,
    leg_of,
)
from workbench.planning.picking.search import Check, PathQuery, joint_weights, onward
from workbench.planning.picking.synchronized_motion import in_step

CARRYING = LEG_NAMES.index("return")
"""From this leg on the first arm's part is out of the bin: in its hand, or where it is put."""


@dataclass(frozen=True, slots=True, eq=False)
class ArmTask:
    """An arm with its plan, and the leg that is to run."""

    plan: ArmPlan
    name: LegName

    @property
    def leg(self) -> Leg:
        """The leg as planned until now."""
        return self.plan.leg(self.name)

    def with_leg(self, leg: Leg) -> "ArmTask":
        """The same task with another way."""
        legs = tuple(leg if old.name == leg.name else old for old in self.plan.legs)
        return ArmTask(replace(self.plan, legs=legs), self.name)


Pair = tuple[ArmTask, ArmTask]


def pairs_of(world: World, picks: Sequence[Pick], cost: Cost) -> list[tuple[Pick, Pick]]:
    """Picks of different arms and parts, by two; least cost first, in and among them.

    What costs the same goes by time.  Where the library of the parts has pairs of grasps,
    only these are taken, in their order.
    """

    def rank(pick: Pick) -> tuple[float, float]:
        return cost(pick), pick.seconds

    def total(pair: tuple[Pick, Pick]) -> tuple[float, float]:
        return cost(pair[0]) + cost(pair[1]), pair[0].seconds + pair[1].seconds

    pairs = [
        (a, b)
        for a, b in permutations(picks, 2)
        if a.candidate.arm != b.candidate.arm
        and a.candidate.detection != b.candidate.detection
        and _may_go_first(world, a, b, is_cheaper=rank(a) <= rank(b))
    ]
    return sorted(pairs, key=total)


def _may_go_first(world: World, a: Pick, b: Pick, *, is_cheaper: bool) -> bool:
    """Whether two arms may take parts by these grasps with `a` going first."""
    first_part, second_part = (
        world.cell.part(world.detections[p.candidate.detection].part) for p in (a, b)
    )
    if first_part.name != second_part.name or not first_part.library.pairs:
        return is_cheaper
    first, second = a.candidate.grasp.name, b.candidate.grasp.name
    allows = first_part.library.allows
    return allows(first, second) and (is_cheaper or not allows(second, first))


def ends_are_clear(world: World, pair: Sequence[Pick]) -> bool:
    """Whether two arms keep apart where the legs of their picks end, both having done as many."""
    ends: tuple[tuple[LegName, list[Floats]], ...] = (
        ("approach", [pick.approach[0] for pick in pair]),
        ("extract", [pick.extract[0] for pick in pair]),
        ("extract", [pick.extract[-1] for pick in pair]),
        ("place", [pick.place[-1] for pick in pair]),
    )
    for name, qs in ends:
        world.enter(phase_of([_run(pick, name) for pick in pair]))
        state = {pick.candidate.arm: q for pick, q in zip(pair, qs, strict=True)}
        if world.meets(world.configuration(state)):
            return False
    return True


def _run(pick: Pick, name: LegName) -> Run:
    """A leg of a pick that has no plan yet."""
    candidate, grasp = pick.candidate, pick.candidate.grasp
    taken = candidate.detection, grasp.name, pick.T_tcp_part
    plan = ArmPlan(candidate.arm, *taken, (), (), tcp=candidate.tcp)
    return plan, name, grasp.grip if name in HOLDING else grasp.opening


def coordinate(
    world: World, picks: Sequence[Pick], *, scan_digest: str, seed: int
) -> Plan | Verdict:
    """A plan in which two arms do the same at the same time, others standing at home as obstacles.

    Args:
        world: of the cell and the detections that the picks were made from.
        picks: two, of different arms and parts.
        scan_digest: what the detections were found in.
        seed: of everything random.

    Returns:
        The plan, or the verdict on the legs for which there is no way.
    """
    single = arm_plan(world, picks[0], seed)
    if isinstance(single, Verdict):
        return single
    other = arm_plan(world, picks[1], seed, (single,), CARRYING)
    if isinstance(other, Verdict):
        return other
    rng, steps = np.random.default_rng(np.random.SeedSequence([seed, 0])), list[Step]()
    guarantee = Guarantee.TIME_INDEPENDENT
    for name in LEG_NAMES:
        together = _combine_legs(world, (ArmTask(single, name), ArmTask(other, name)), rng)
        if isinstance(together, Verdict):
            return together
        (first, second), some, is_in_step = together
        single, other = first.plan, second.plan
        steps += some
        if is_in_step:
            guarantee = Guarantee.SYNCHRONISED
    return Plan(
        cell=world.cell.name,
        cell_digest=world.cell.digest,
        scan_digest=scan_digest,
        seed=seed,
        strategy=Strategy.COORDINATED,
        guarantee=guarantee,
        detections=world.detections,
        obstacles=world.obstacles,
        arms=(single, other),
        sequence=tuple(steps),
    )


def _combine_legs(
    world: World, pair: Pair, rng: np.random.Generator
) -> tuple[Pair, list[Step], bool] | Verdict:
    """Two legs by the first way that works: the tasks, their steps, and whether in step."""
    one_step = [Step(tuple((task.plan.arm, task.name) for task in pair))]
    touch = find_arm_contact(world, pair)
    if touch is None:
        return pair, one_step, False
    for around in _lead_around(world, pair, rng):
        return around, one_step, False
    turns = _one_after_the_other(world, pair)
    if turns is not None:
        return pair, turns, False
    _enter(world, pair)
    legs = in_step(world, (pair[0].plan, pair[1].plan), pair[0].name, rng)
    if legs is not None:
        return (pair[0].with_leg(legs[0]), pair[1].with_leg(legs[1])), one_step, True
    where = VerdictNote.ARMS_MEET(
        legs=(VerdictNote.ARM_LEG(arm=task.plan.arm, leg=leg_message(task.name)) for task in pair)
    )
    return touch.contact.refuse(Reason.NO_PATH, Stage.ROUTE, touch.q[0], where)


def _enter(world: World, pair: Pair) -> None:
    """Both legs under way."""
    world.enter(phase_of([(task.plan, task.name, task.leg.opening) for task in pair]))
    if any(task.name in LEAVING for task in pair):
        starts = {task.plan.arm: task.leg.q[0] for task in pair}
        world.allow_start_contacts(world.configuration(starts))


def _sweep_of(world: World, task: ArmTask) -> ArmSweep:
    curves = bound_curves(np.asarray(task.leg.q), world.motion, world.policy.zone)
    return ArmSweep(task.plan.arm, curves.points)


def find_arm_contact(world: World, pair: Pair) -> ArmContact | None:
    """A contact of one arm with the other, or with a part that the other has placed.

    With such a part, the arm that does not meet it is given where its leg begins.
    """
    _enter(world, pair)
    for number, task in enumerate(pair):
        found = along_placed(world, task.plan.arm, np.asarray(task.leg.q))
        if found is not None:
            q = [np.asarray(each.leg.q[0]) for each in pair]
            q[number] = found[1]
            return ArmContact(found[0], (q[0], q[1]), (0, 0))
    first, second = (_sweep_of(world, task) for task in pair)
    return first_contact(world, world.configuration({}), first, second)


def _lead_around(world: World, pair: Pair, rng: np.random.Generator) -> Iterator[Pair]:
    """The pair with the free motion of one arm led around the whole way of the other."""
    for slave, master in ((1, 0), (0, 1)):
        task = pair[slave]
        if MOTIONS[task.name] != "joint":
            continue
        base = world.configuration({})
        way, goal = _sweep_of(world, pair[master]), np.asarray(task.leg.q[-1])
        lead = lead_of(task.leg, world.policy.straight_points)
        begin = standing(task.plan.arm, lead[0])
        if len(lead) > 1:
            begin = ArmSweep(
                task.plan.arm, bound_curves(lead, world.motion, world.policy.zone).points
            )
        ends = (begin, standing(task.plan.arm, goal))
        if any(first_contact(world, base, end, way) is not None for end in ends):
            continue
        if along_placed(world, task.plan.arm, lead) is not None:
            continue
        chain = world.chains[task.plan.arm]
        query = PathQuery(
            _check_around(world, task.plan.arm, way),
            (chain.lower, chain.upper),
            joint_weights(len(goal), world.policy),
            world.policy,
            world.motion,
            world.deadline,
            pace=pace_of(chain, world.policy.speed),
            upright=keep_upright(world, [task.plan], task.name),
        )
        with world.at_full_margins():
            path = onward(query, lead, goal, rng)
        if isinstance(path, Verdict):
            continue
        arm, hand = world.arm(task.plan.arm), hand_of(world, task.plan)
        leg = leg_of(world, arm, task.name, path, task.leg.opening, hand)
        led = task.with_leg(leg)
        yield (pair[0], led) if slave else (led, pair[1])


def _check_around(world: World, arm: str, way: ArmSweep) -> Check:
    """Whether motions of an arm are clear, also of all that another arm sweeps on its `way`."""
    columns, base = world.kinematics.columns[arm], world.configuration({})
    among = world.pairs.all_but(arm, way.arm)

    def check(curves: Curves) -> tuple[Contact | None, Floats] | None:
        found = chain_contact(world, columns, base, curves, among=among)
        if found is not None:
            return found[:2]
        touch = first_contact(world, base, ArmSweep(arm, curves.points), way)
        return None if touch is None else (touch.contact, touch.q[0])

    return check


def _one_after_the_other(world: World, pair: Pair) -> list[Step] | None:
    """Two steps, the waiting arm standing where its leg begins or ended; None when they meet."""
    done = LEG_NAMES.index(pair[0].name)
    for first, second in (pair, pair[::-1]):
        if passes(world, first, second.plan, done) and passes(world, second, first.plan, done + 1):
            return [Step(((task.plan.arm, task.name),)) for task in (first, second)]
    return None


def passes(world: World, moving: ArmTask, waiting: ArmPlan, done: int) -> bool:
    """Whether one arm can go while the other stands where it is with this many of its legs done."""
    waits: list[Run] = []
    if done:
        last = waiting.legs[done - 1]
        waits.append((waiting, last.name, last.opening))
    world.enter(phase_of([(moving.plan, moving.name, moving.leg.opening)], waits))
    q = np.asarray(waiting.legs[done - 1].q[-1] if done else waiting.legs[0].q[0])
    if moving.name in LEAVING:
        starts = {moving.plan.arm: moving.leg.q[0], waiting.arm: q}
        world.allow_start_contacts(world.configuration(starts))
    if along_placed(world, moving.plan.arm, np.asarray(moving.leg.q)) is not None:
        return False
    post = standing(waiting.arm, q)
    return first_contact(world, world.configuration({}), _sweep_of(world, moving), post) is None

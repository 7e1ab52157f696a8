"""Two arms at once: which legs run together, and that the arms cannot meet on them.

Both arms run the same legs.  They run side by side, or the second one follows some legs behind
the first, so that one works in the bin while the other carries its part away: of the offsets
that work the one with the shortest cycle is taken.  For two legs that run together these are
tried in turn:

1. both ways as planned for each arm alone, when the arms cannot meet on them whatever their
   speeds (`meeting`);
2. the way of one arm searched anew around the whole way of the other, first that of the second
   (the thesis' master and slave);
3. one after the other;
4. side by side only: both as one motion of all joints, run in step.

A plan without legs in step is safe at any speeds: arms wait for each other between steps only.

In an alternated plan, too, the second arm may be on its way to the bin while the first goes home.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from workbench.model.candidate import Pick, Reason, Stage, Verdict
from workbench.model.geometry import Floats
from workbench.model.plan import LEG_NAMES, ArmPlan, Guarantee, Leg, LegName, Plan, Step, Strategy
from workbench.planning.collision.arm_sweeps import ArmContact, ArmSweep, first_contact, standing
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.legs import HOLDING, LEAVING, Run, lead_of, phase_of
from workbench.planning.collision.motion import Curves, chain_contact, walked
from workbench.planning.collision.world import World
from workbench.planning.picking.in_step import in_step
from workbench.planning.picking.order import Cost
from workbench.planning.picking.route import MOTIONS, along_placed, arm_plan, leg_of
from workbench.planning.picking.search import joint_weights, onward
from workbench.planning.planners.clock import working_time

OFFSETS = range(5)
"""By how many legs the second arm may follow the first; with more they would not overlap much."""

HOMEWARD = LEG_NAMES.index("home")
"""So many legs behind the first, the second arm leaves while the first goes home."""

CARRYING = LEG_NAMES.index("return")
"""From this leg on the first arm's part is out of the bin: in its hand, or where it is put."""


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """An arm with its plan so far, and the leg that is to run."""

    plan: ArmPlan
    name: LegName

    @property
    def leg(self) -> Leg:
        """The leg as planned so far."""
        return self.plan.leg(self.name)

    def with_leg(self, leg: Leg) -> "Task":
        """The same task with another way."""
        legs = tuple(leg if old.name == leg.name else old for old in self.plan.legs)
        return Task(replace(self.plan, legs=legs), self.name)


Pair = tuple[Task, Task]


def pairs_of(world: World, picks: Sequence[Pick], cost: Cost) -> list[tuple[Pick, Pick]]:
    """Picks of different arms and parts, by two; least cost first, in and among them.

    What costs the same goes by joint travel.  Where the library of the parts has pairs of grasps,
    only these are taken, in their order.
    """

    def rank(pick: Pick) -> tuple[float, float]:
        return cost(pick), pick.travel

    def total(pair: tuple[Pick, Pick]) -> tuple[float, float]:
        return cost(pair[0]) + cost(pair[1]), pair[0].travel + pair[1].travel

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
    one, other = (world.cell.part(world.detections[p.candidate.detection].part) for p in (a, b))
    if one.name != other.name or not one.library.pairs:
        return is_cheaper
    first, second = a.candidate.grasp.name, b.candidate.grasp.name
    allows = one.library.allows
    return allows(first, second) and (is_cheaper or not allows(second, first))


def side_by_side(world: World, picks: Sequence[Pick], cost: Cost) -> list[tuple[Pick, Pick]]:
    """Pairs of picks whose arms do not touch where their legs end, least cost first.

    They are worth a plan in which both arms do the same at the same time.
    """
    return [pair for pair in pairs_of(world, picks, cost) if _ends_are_clear(world, pair)]


def _ends_are_clear(world: World, pair: tuple[Pick, Pick]) -> bool:
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
    plan = ArmPlan(candidate.arm, candidate.detection, grasp.name, pick.T_tcp_part, (), ())
    return plan, name, grasp.grip if name in HOLDING else grasp.opening


def coordinate(
    world: World,
    picks: Sequence[Pick],
    *,
    scan_digest: str,
    seed: int,
    offsets: Sequence[int] = OFFSETS,
) -> Plan | Verdict:
    """A plan in which two arms work at once, others standing at home as obstacles.

    Args:
        world: of the cell and the detections that the picks were made from.
        picks: two, of different arms and parts; the first arm begins.
        scan_digest: what the detections were found in.
        seed: of everything random.
        offsets: by how many legs the second arm may follow the first.

    Returns:
        The plan with the shortest cycle, side by side if that works; or the verdict of the first
        offset, `OUT_OF_TIME` once the world's deadline has passed.
    """
    first = arm_plan(world, picks[0], seed)
    if isinstance(first, Verdict):
        return first
    refusal: Verdict | None = None
    best: Plan | None = None
    second: ArmPlan | Verdict | None = None
    planned_since = -1
    for offset in offsets:
        if working_time() > world.deadline:
            break
        since = max(0, CARRYING - offset)
        if second is None or since != planned_since:
            second, planned_since = arm_plan(world, picks[1], seed, (first,), since), since
        if isinstance(second, Verdict):
            refusal = refusal or second
            continue
        rng = np.random.default_rng(np.random.SeedSequence([seed, offset]))
        found = _with_offset(world, first, second, offset, rng)
        if isinstance(found, Verdict):
            refusal = refusal or found
            continue
        arms, steps, guarantee = found
        plan = Plan(
            cell=world.cell.name,
            cell_digest=world.cell.digest,
            scan_digest=scan_digest,
            seed=seed,
            strategy=Strategy.COORDINATED,
            guarantee=guarantee,
            detections=world.detections,
            obstacles=world.obstacles,
            arms=arms,
            sequence=steps,
            note=_note(offset),
        )
        if best is None or plan.cycle_seconds < best.cycle_seconds:
            best = plan
        if offset == 0:
            break
    if best is None and working_time() > world.deadline:
        return Verdict(Reason.OUT_OF_TIME, Stage.ROUTE)
    return best or refusal or Verdict(Reason.NO_PATH, Stage.ROUTE)


def overlapped(world: World, plan: Plan) -> Plan:
    """An alternated plan whose second arm sets out while the first goes home.

    Args:
        world: of the cell and the detections that the plan was made for.
        plan: for two arms, one after the other.

    Returns:
        That plan, which no proof has seen yet; `plan` itself where the arms might meet or nothing
        is won.
    """
    first, second = plan.arms
    rng = np.random.default_rng(np.random.SeedSequence([plan.seed, HOMEWARD]))
    found = _with_offset(world, first, second, HOMEWARD, rng)
    if isinstance(found, Verdict):
        return plan
    arms, steps, guarantee = found
    shorter = replace(plan, arms=arms, sequence=steps, guarantee=guarantee)
    # Legs that take turns after all may be quicker by a rounding error: that is nothing won.
    is_at_once = any(len(step.runs) > 1 for step in steps)
    return shorter if is_at_once and shorter.cycle_seconds < plan.cycle_seconds else plan


def _note(offset: int) -> str:
    if offset == 0:
        return "both arms side by side"
    return f"the second arm {offset} {'leg' if offset == 1 else 'legs'} behind the first"


def _with_offset(
    world: World, first: ArmPlan, second: ArmPlan, offset: int, rng: np.random.Generator
) -> tuple[tuple[ArmPlan, ArmPlan], tuple[Step, ...], Guarantee] | Verdict:
    """Arms, steps and guarantee with the second arm `offset` legs behind the first."""
    steps = [Step(((first.arm, name),)) for name in LEG_NAMES[:offset]]
    guarantee = Guarantee.TIME_INDEPENDENT
    for ahead, behind in zip(LEG_NAMES[offset:], LEG_NAMES, strict=False):
        together = _together(world, (Task(first, ahead), Task(second, behind)), rng)
        if isinstance(together, Verdict):
            return together
        (one, other), some, is_in_step = together
        first, second = one.plan, other.plan
        steps += some
        if is_in_step:
            guarantee = Guarantee.SYNCHRONISED
    steps += [Step(((second.arm, name),)) for name in LEG_NAMES[len(LEG_NAMES) - offset :]]
    return (first, second), tuple(steps), guarantee


def _together(
    world: World, pair: Pair, rng: np.random.Generator
) -> tuple[Pair, list[Step], bool] | Verdict:
    """Two legs by the first way that works: the tasks, their steps, and whether in step."""
    one_step = [Step(tuple((task.plan.arm, task.name) for task in pair))]
    met = _met(world, pair)
    if met is None:
        return pair, one_step, False
    for around in _around(world, pair, rng):
        return around, one_step, False
    turns = _one_after_the_other(world, pair)
    if turns is not None:
        return pair, turns, False
    if pair[0].name == pair[1].name:
        _enter(world, pair)
        legs = in_step(world, (pair[0].plan, pair[1].plan), pair[0].name, rng)
        if legs is not None:
            return (pair[0].with_leg(legs[0]), pair[1].with_leg(legs[1])), one_step, True
    contact = met.contact
    where = f"the arms meet: {' and '.join(f'{task.plan.arm} {task.name}' for task in pair)}"
    return Verdict(Reason.NO_PATH, Stage.ROUTE, contact.pair, contact.distance, met.q[0], where)


def _enter(world: World, pair: Pair) -> None:
    """Both legs under way."""
    world.enter(phase_of([(task.plan, task.name, task.leg.opening) for task in pair]))
    if any(task.name in LEAVING for task in pair):
        starts = {task.plan.arm: task.leg.q[0] for task in pair}
        world.allow_start_contacts(world.configuration(starts))


def _sweep_of(world: World, task: Task) -> ArmSweep:
    curves = walked(np.asarray(task.leg.q), world.policy.zone)
    return ArmSweep(task.plan.arm, curves.points)


def _met(world: World, pair: Pair) -> ArmContact | None:
    """Where the arms meet, or one what the other has placed, on the ways that they have."""
    _enter(world, pair)
    for task in pair:
        contact = along_placed(world, task.plan.arm, np.asarray(task.leg.q))
        if contact is not None:
            return ArmContact(contact, (pair[0].leg.q[0], pair[1].leg.q[0]), (0, 0))
    first, second = (_sweep_of(world, task) for task in pair)
    return first_contact(world, world.configuration({}), first, second)


def _around(world: World, pair: Pair, rng: np.random.Generator) -> Iterator[Pair]:
    """The pair with the free way of one arm led around the whole way of the other."""
    for slave, master in ((1, 0), (0, 1)):
        task = pair[slave]
        if MOTIONS[task.name] != "joint":
            continue
        columns, base = world.kinematics.columns[task.plan.arm], world.configuration({})
        way, goal = _sweep_of(world, pair[master]), np.asarray(task.leg.q[-1])
        lead = lead_of(task.leg, world.policy.straight_points)
        begin = standing(task.plan.arm, lead[0])
        if len(lead) > 1:
            begin = ArmSweep(task.plan.arm, walked(lead, world.policy.zone).points)
        ends = (begin, standing(task.plan.arm, goal))
        if any(first_contact(world, base, end, way) is not None for end in ends):
            continue
        if along_placed(world, task.plan.arm, lead) is not None:
            continue
        among = world.pairs.all_but(task.plan.arm, way.arm)

        def check(
            curves: Curves,
            base: Floats = base,
            columns: np.ndarray = columns,
            among: np.ndarray = among,
            arm: str = task.plan.arm,
            way: ArmSweep = way,
        ) -> tuple[Contact, Floats] | None:
            found = chain_contact(world, columns, base, curves, among=among)
            if found is not None:
                return found[:2]
            met = first_contact(world, base, ArmSweep(arm, curves.points), way)
            return None if met is None else (met.contact, met.q[0])

        chain, weights = world.chains[task.plan.arm], joint_weights(len(columns), world.policy)
        limits = (chain.lower, chain.upper)
        with world.at_full_margins():
            path = onward(
                lead,
                goal,
                limits,
                weights,
                check,
                world.policy,
                world.motion,
                rng,
                world.deadline,
            )
        if isinstance(path, Verdict):
            continue
        leg = leg_of(world, world.arm(task.plan.arm), task.name, path, task.leg.opening)
        led = task.with_leg(leg)
        yield (pair[0], led) if slave else (led, pair[1])


def _one_after_the_other(world: World, pair: Pair) -> list[Step] | None:
    """Two steps, the waiting arm standing where its leg begins or ended; None when they meet."""
    for one, other in (pair, pair[::-1]):
        if _passes(world, one, other, is_done=False) and _passes(world, other, one, is_done=True):
            return [Step(((task.plan.arm, task.name),)) for task in (one, other)]
    return None


def _passes(world: World, moving: Task, waiting: Task, *, is_done: bool) -> bool:
    """Whether one arm can go while the other stands where its leg ended, or where it begins."""
    last = waiting.name if is_done else _before(waiting.name)
    waits: list[Run] = []
    if last is not None:
        waits.append((waiting.plan, last, waiting.plan.leg(last).opening))
    world.enter(phase_of([(moving.plan, moving.name, moving.leg.opening)], waits))
    q = np.asarray(waiting.leg.q[-1 if is_done else 0])
    if moving.name in LEAVING:
        starts = {moving.plan.arm: moving.leg.q[0], waiting.plan.arm: q}
        world.allow_start_contacts(world.configuration(starts))
    if along_placed(world, moving.plan.arm, np.asarray(moving.leg.q)) is not None:
        return False
    post = standing(waiting.plan.arm, q)
    return first_contact(world, world.configuration({}), _sweep_of(world, moving), post) is None


def _before(name: LegName) -> LegName | None:
    number = LEG_NAMES.index(name)
    return LEG_NAMES[number - 1] if number else None

"""Tries to have a plan proven that must not be: good plans, changed by somebody who wants to."""

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from bending import with_leg

from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import UNSIGNED, Guarantee, Plan, Step, Strategy
from workbench.model.scan import Obstacle, Scene
from workbench.proof.claims.prove import prove

Change = Callable[[Plan], Plan]


def exchanged(plan: Plan, *names: str) -> Plan:
    """The two arms with each other's fields."""
    one, other = plan.arms
    arms = (
        replace(one, **{name: getattr(other, name) for name in names}),
        replace(other, **{name: getattr(one, name) for name in names}),
    )
    return replace(plan, arms=arms)


def standing(plan: Plan, name: str) -> Plan:
    """A leg of no length where it ends, to which the one before goes on."""
    one = plan.arms[0]
    names, q = [leg.name for leg in one.legs], np.asarray(one.leg(name).q)
    before = names[names.index(name) - 1]
    way = np.vstack([one.leg(before).q, q[-1:]])
    times = np.append(one.leg(before).t, one.leg(before).seconds + 20.0)
    plan = with_leg(plan, one.arm, before, q=way, t=times)
    return with_leg(plan, one.arm, name, q=q[[-1, -1]], t=np.array([0.0, 1.0]))


def unlifted(plan: Plan) -> Plan:
    """A lift of no length: the way to the place begins where the part lies."""
    one = plan.arms[0]
    start, back = np.asarray(one.leg("extract").q)[:1], one.leg("return")
    plan = with_leg(plan, one.arm, "extract", q=start[[0, 0]], t=np.array([0.0, 1.0]))
    times = np.append(0.0, np.asarray(back.t) + 20.0)
    return with_leg(plan, one.arm, "return", q=np.vstack([start, back.q]), t=times)


def renamed(plan: Plan) -> Plan:
    """Each arm under the other one's name, in its legs' order, too."""
    names = {one.arm: other.arm for one, other in zip(plan.arms, plan.arms[::-1], strict=True)}
    arms = tuple(replace(one, arm=names[one.arm]) for one in plan.arms)
    steps = (Step(tuple((names[arm], leg) for arm, leg in step.runs)) for step in plan.sequence)
    return replace(plan, arms=arms, sequence=tuple(steps))


def twice_unsure(plan: Plan) -> Plan:
    """The part that is taken once more, as one whose roll is not known."""
    taken = plan.detections[plan.arms[0].detection]
    return replace(plan, detections=(*plan.detections, replace(taken, roll_known=False)))


def half_turned(plan: Plan) -> Plan:
    one, turn = plan.arms[0], pose_from_rpy((0, 0, 0), (0, 0, np.pi))
    return replace(plan, arms=(replace(one, T_tcp_part=one.T_tcp_part * turn), *plan.arms[1:]))


def at_once(plan: Plan) -> Plan:
    """Leg beside leg, in step by its own word, with times that differ."""
    first, second = plan.arms
    steps = [Step(((first.arm, a.name), (second.arm, a.name))) for a in first.legs]
    said = {"strategy": Strategy.COORDINATED, "guarantee": Guarantee.SYNCHRONISED}
    return replace(plan, sequence=tuple(steps), **said)


def same_place(plan: Plan) -> Plan:
    """The second arm goes on to the place from which it comes: it lets go where it has lifted."""
    one = plan.arms[1]
    back = np.asarray(one.leg("extract").q)[::-1]
    plan = with_leg(plan, one.arm, "place", q=back, t=np.linspace(0.0, 9.0, len(back)))
    lifted = back[:1]
    plan = with_leg(plan, one.arm, "return", q=np.vstack([lifted, lifted]), t=np.array([0.0, 1.0]))
    home = np.vstack([back[-1:], np.asarray(one.leg("home").q)[-1:]])
    return with_leg(plan, one.arm, "home", q=home, t=np.array([0.0, 9.0]))


TRIES: dict[str, tuple[Change, str]] = {
    "arms by each other's names": (renamed, "joints are not those of the arm"),
    "arms with each other's parts": (
        lambda plan: exchanged(plan, "detection"),
        "the part is not where the hand closes",
    ),
    "arms with each other's ways": (
        lambda plan: exchanged(plan, "legs", "T_tcp_part", "detection", "grasp"),
        "does not start where the arm stands",
    ),
    "an approach of no length": (
        lambda plan: standing(plan, "approach"),
        "does not go in the direction",
    ),
    "a lift of no length": (unlifted, "leg return after waypoint 0: within the safety margin"),
    "a way home of no length": (lambda plan: standing(plan, "home"), "is not straight"),
    "a part twice, once of unknown roll": (twice_unsure, "within the safety margin"),
    "a part the other way round in the hand": (half_turned, "the part is not where the hand"),
    "both at once, in step by their word alone": (at_once, "within the safety margin"),
    "a part let go of where it lay": (same_place, "the hand opens where the arm has no place"),
}


@pytest.mark.parametrize("name", TRIES)
def test_what_an_enemy_changes_is_found(cell, result, name):
    change, says = TRIES[name]
    plan = change(result.plan)
    proof = prove(cell, Scene(plan.scan_digest, plan.detections, plan.obstacles), plan)
    assert not proof.holds
    assert any(says in str(one) for one in proof.violations), [str(v) for v in proof.violations]


def others(value: Any) -> Iterator[Any]:
    """The value with each thing in it changed, one at a time, by as little as can be."""
    if is_dataclass(value):
        for one in fields(value):
            if one.init and one.name not in UNSIGNED:
                for other in others(getattr(value, one.name)):
                    yield replace(value, **{one.name: other})
    elif isinstance(value, tuple):
        yield from (
            value[:k] + (other,) + value[k + 1 :]
            for k, v in enumerate(value)
            for other in others(v)
        )
        yield (*value, value[-1]) if value else value
    elif isinstance(value, np.ndarray):
        for k in np.ndindex(value.shape):
            other = np.array(value)
            other[k] = np.nextafter(other[k], np.inf)
            yield other
    elif isinstance(value, pin.SE3):
        yield pin.SE3(value.rotation, np.nextafter(value.translation, np.inf))
        yield pin.SE3(np.nextafter(value.rotation, np.inf), value.translation)
    elif isinstance(value, Strategy):
        yield Strategy(f"{value}x")
    elif isinstance(value, Guarantee):
        yield from (one for one in Guarantee if one is not value)
    elif isinstance(value, bool):
        yield not value
    elif isinstance(value, str):
        yield value + "x"
    elif isinstance(value, int):
        yield value + 1
    elif isinstance(value, float):
        yield np.nextafter(value, np.inf).item()


def test_no_two_plans_that_differ_in_anything_have_one_digest(result):
    """One waypoint by a last bit, a name by a letter: what was approved is another plan then."""
    T, size = pose_from_rpy((0.1, 0.2, 0.3)), np.array([0.01, 0.02, 0.03])
    box, put = Obstacle(T, size), Obstacle(T, size, "puck", pose_from_rpy((0.1, 0.2, 0.4)))
    plan = replace(result.plan, obstacles=(put,))
    unsaid = replace(result.plan, obstacles=(box,))
    digests = [plan.digest, unsaid.digest, *(other.digest for other in others(plan))]
    assert len(digests) > 500
    assert len(set(digests)) == len(digests)

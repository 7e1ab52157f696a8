"""What a plan may say of itself: which legs of two arms that take turns may run at once."""

from dataclasses import replace

import pytest

from workbench.model.motion import LEG_NAMES
from workbench.model.plan import Guarantee, Plan, Step, Strategy
from workbench.proof.claims.form import form_violations


def one_by_one(plan: Plan) -> tuple[Step, ...]:
    """Every leg of the first arm, then every leg of the second."""
    return tuple(Step(((arm.arm, leg.name),)) for arm in plan.arms for leg in arm.legs)


def together(plan: Plan, ahead: str, behind: str) -> tuple[Step, ...]:
    """A leg of the first arm with one of the second; what comes before each goes before both."""
    first, second = (arm.arm for arm in plan.arms)
    k, m = LEG_NAMES.index(ahead), LEG_NAMES.index(behind)
    before = [(first, name) for name in LEG_NAMES[:k]] + [(second, name) for name in LEG_NAMES[:m]]
    after = [(first, name) for name in LEG_NAMES[k + 1 :]]
    after += [(second, name) for name in LEG_NAMES[m + 1 :]]
    both = Step(((first, ahead), (second, behind)))
    return (*(Step((run,)) for run in before), both, *(Step((run,)) for run in after))


@pytest.fixture(scope="module")
def overlapped(result) -> Plan:
    """Said to take turns, the second arm setting out while the first goes home."""
    said = replace(result.plan, strategy=Strategy.ALTERNATED, guarantee=Guarantee.TIME_INDEPENDENT)
    return replace(said, sequence=together(said, "home", "reach"))


def problems(cell, plan: Plan) -> list[str]:
    return [str(violation) for violation in form_violations(cell, plan.scene, plan)]


def test_the_second_arm_may_set_out_while_the_first_goes_home(cell, overlapped):
    assert problems(cell, overlapped) == []
    in_turn = replace(
        overlapped, sequence=one_by_one(overlapped), guarantee=Guarantee.ONE_AT_A_TIME
    )
    assert problems(cell, in_turn) == []


def home_last(plan: Plan) -> Plan:
    """The second arm sets out before the first goes home, both alone."""
    steps = list(one_by_one(plan))
    k = len(LEG_NAMES) - 1
    steps[k], steps[k + 1] = steps[k + 1], steps[k]
    return replace(plan, sequence=tuple(steps))


def second_first(plan: Plan) -> Plan:
    """In the step of both arms the second is named first."""
    steps = (Step(step.runs[::-1]) for step in plan.sequence)
    return replace(plan, sequence=tuple(steps))


def alone(plan: Plan) -> Plan:
    arm = plan.arms[0]
    only = replace(plan, arms=(arm,), strategy=Strategy.single(arm.arm))
    return replace(only, sequence=one_by_one(only))


@pytest.mark.parametrize(
    ("bend", "says"),
    [
        (lambda p: replace(p, sequence=together(p, "home", "approach")), "one after the other"),
        (lambda p: replace(p, sequence=together(p, "place", "reach")), "one after the other"),
        (home_last, "one arm after the other"),
        (second_first, "one arm after the other"),
        (lambda p: replace(p, arms=p.arms[::-1]), "one arm after the other"),
        (lambda p: replace(p, guarantee=Guarantee.SYNCHRONISED), "one after the other"),
        (lambda p: replace(p, guarantee=Guarantee.ONE_AT_A_TIME), "one arm after the other"),
        (lambda p: replace(p, sequence=one_by_one(p)), "never moves two arms at once"),
        (alone, "never moves two arms at once"),
        (
            lambda p: replace(alone(p), guarantee=Guarantee.SYNCHRONISED),
            "never moves two arms at once",
        ),
    ],
)
def test_a_plan_in_which_arms_take_turns_is_refused_for_any_other_order(
    cell, overlapped, bend, says
):
    found = problems(cell, bend(overlapped))
    assert any(says in problem for problem in found), found

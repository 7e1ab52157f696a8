"""What any link hands on is looked at: a number that cannot be ends a sending by any link."""

import math
import time
from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.model.errors import ProtocolError
from workbench.model.geometry import pose_from_rpy
from workbench.model.motion import MotionModel
from workbench.model.plan import ArmPlan, Guarantee, Leg, Plan, Step, Strategy
from workbench.model.release import Approval, LinkStatus, PartReport, Receipt, RobotState
from workbench.plugins import robot_link
from workbench.plugins.report_checks import BEYOND, bounds_of
from workbench.plugins.robot_link import send, states

NO_NUMBERS = [math.nan, math.inf, -math.inf, "1.0", None, True, 10**5000]
NO_JOINTS = [*NO_NUMBERS, 1e308, -1e308, 10**400, 50.0]
NO_COUNTS = [*NO_NUMBERS, -1, 1.0, 1e308]


@pytest.fixture(scope="module")
def cell():
    made = read_cell("yumi")
    return replace(made, controller=replace(made.controller, motion=MotionModel("told")))


@pytest.fixture
def sending(cell, monkeypatch):
    """A plan of one leg, approved; the link that is to send it tells what a test says."""
    arm = cell.arms[0]
    q = np.array([arm.home, arm.home + 0.1])
    leg = Leg("reach", "joint", False, 0.03, q, np.array([0.0, 1.0]))
    takes = ArmPlan(arm.name, 3, "top", pose_from_rpy(np.zeros(3), (0, 0, 0)), arm.joints, (leg,))
    step = Step(((arm.name, "reach"),))
    single = Strategy.single(arm.name)
    plan = Plan(
        cell.name, cell.digest, "scan", 0, single, Guarantee.ONE_AT_A_TIME, (), (takes,), (step,)
    )
    now = time.time()
    approval = Approval(plan.digest, "", cell.digest, "scan", "ada", now, now + 3600.0)
    return plan, approval, cell, Told(monkeypatch)


class Told:
    """A link that is written elsewhere: it hands on whatever it is given."""

    def __init__(self, monkeypatch):
        self.says, self.is_closed, self.shown = [], False, []
        self.motion = MotionModel("told")
        monkeypatch.setattr(robot_link, "link_named", lambda name: self)

    def send(self, plan, approval, cell, *, show, **_):
        try:
            for one in self.says:
                if isinstance(one, LinkStatus):
                    show(one)
                else:
                    yield one
        finally:
            self.is_closed = True

    def states(self, cell, cancelled):
        try:
            yield from self.says
        finally:
            self.is_closed = True

    def sent(self, plan, approval, cell, *says):
        self.says = says
        return list(send(plan, approval, cell, show=self.shown.append))


SENT = Receipt(1000.0, "right", "reach", "go", 1, 1)


def refused(sending, *says, match):
    *given, link = sending
    with pytest.raises(ProtocolError, match=match) as error:
        link.sent(*given, *says)
    assert link.is_closed, "whoever doubts closes the link"
    assert len(str(error.value)) < 200


def named(value):
    """A number of five thousand digits cannot be written."""
    return f"{value!r:.12}" if not isinstance(value, int) or abs(value) < 2 else "huge"


@pytest.mark.parametrize("value", NO_JOINTS, ids=named)
@pytest.mark.parametrize("k", [0, 6])
def test_a_joint_that_cannot_be_ends_a_sending_by_any_link(sending, value, k):
    arm = sending[2].arms[0]
    q = list(arm.home)
    q[k] = value
    says = LinkStatus("told", "runs", joints={arm.name: q})
    refused(sending, says, SENT, match=f"reports {arm.joints[k]} ")


def test_joints_of_no_arm_and_too_many_or_too_few_are_refused(sending):
    home = tuple(sending[2].arms[0].home)
    for joints, says in (
        ({"third": home}, "reports an arm 'third'"),
        ({"right": home[:-1]}, "reports 6 joints where the arm has 7"),
        ({"right": (*home, 0.0)}, "reports 8 joints where the arm has 7"),
    ):
        refused(sending, LinkStatus("told", joints=joints), match=says)


@pytest.mark.parametrize("value", NO_COUNTS, ids=named)
@pytest.mark.parametrize("what", ["done", "total", "waits", "step"])
def test_a_count_that_cannot_be_ends_a_sending(sending, what, value):
    refused(sending, replace(SENT, **{what: value}), match="reports the ")


NO_TIMES = [
    (what, value)
    for what in ("acknowledged_at", "reported_at", "stopped", "at")
    for value in (*NO_NUMBERS, -1.0, 1e308)
    if (what, value) != ("stopped", None)
]


@pytest.mark.parametrize(("what", "value"), NO_TIMES, ids=named)
def test_a_time_that_cannot_be_ends_a_sending(sending, what, value):
    of = SENT if what == "at" else LinkStatus("told")
    refused(sending, replace(of, **{what: value}), match="reports (a time|how long)")


def test_what_goes_back_or_beyond_the_plan_is_refused(sending):
    two = replace(SENT, total=2)
    refused(sending, replace(two, done=2), two, match="message 1 is told of after message 2")
    refused(sending, replace(two, done=3), match="reports the message as 3")
    refused(sending, LinkStatus("told", step=3, steps=2), match="reports the step as 3")
    for step in ({"waits": 2}, {"step": 2}):
        refused(sending, replace(SENT, **step), match="reports the step as 2")


def test_parts_are_those_of_the_plan_each_once(sending):
    part = replace(SENT, part=PartReport("right", 3, True))
    for other in (PartReport("left", 3, True), PartReport("right", 4, True)):
        refused(sending, replace(SENT, part=other), match="that is none, or twice")
    refused(sending, part, part, match="that is none, or twice")


def test_a_sending_that_ends_before_all_is_told_has_not_gone_well(sending):
    refused(sending, match="the robot link told has ended too early, with nothing told")
    refused(sending, replace(SENT, total=2), match="too early, at message 1 of 2")
    sending[3].motion = MotionModel("told", reports_progress=True)
    refused(sending, SENT, match="told nothing of the right arm's part")


def test_what_can_be_is_handed_on_as_it_is(sending):
    plan, approval, cell, link = sending
    home = tuple(cell.arms[0].home)
    minus_nothing = (-0.0, *home[1:])
    says = [LinkStatus("told", joints={"right": q}) for q in (home, minus_nothing, np.array(home))]
    assert link.sent(plan, approval, cell, *says, SENT) == [SENT]
    assert link.shown == says and link.is_closed


def test_a_joint_may_be_a_little_beyond_its_limits_or_a_full_turn_off(cell):
    bounds = bounds_of(cell, cell.arms[0])
    for end, way in ((bounds.lower, -1.0), (bounds.upper, 1.0)):
        for off in (0.9 * BEYOND, 2 * math.pi, -2 * math.pi):
            bounds.take(end + way * off)
        with pytest.raises(ProtocolError, match="it goes from"):
            bounds.take(end + way * 1.1 * BEYOND)
        # While nothing moves a person may have jogged it beyond the limits of the cell file.
        bounds.take(end + way * 1.1 * BEYOND, in_motion=False)
        with pytest.raises(ProtocolError, match="it goes from"):
            bounds.take(end + way * (2 * math.pi + 1.1 * BEYOND), in_motion=False)


def test_a_joint_that_slides_turns_nowhere(cell):
    bounds = replace(bounds_of(cell, cell.arms[0]), turns=(False,) * 7)
    bounds.take(bounds.upper + 0.04)
    with pytest.raises(ProtocolError, match=r"mm; it goes from \S+ mm to \S+ mm"):
        bounds.take(bounds.upper + 0.06, in_motion=False)


STATE = RobotState({}, {}, "", 0, 0, "")


@pytest.mark.parametrize(
    "state",
    [
        *(replace(STATE, joints={"right": (value, *[0.0] * 6)}) for value in NO_JOINTS),
        replace(STATE, joints={"right": ()}),
        replace(STATE, joints={"third": (0.0,)}),
        *(replace(STATE, openings={"right": value}) for value in (*NO_NUMBERS, 1e308, -1.0, 0.2)),
        replace(STATE, openings={"third": 0.0}),
        *(replace(STATE, received=value) for value in NO_COUNTS),
        *(replace(STATE, placed=value) for value in NO_COUNTS),
    ],
    ids=lambda state: "",
)
def test_a_state_that_cannot_be_is_not_handed_on(cell, monkeypatch, state):
    link = Told(monkeypatch)
    home = {arm.name: tuple(arm.home) for arm in cell.arms}
    good = replace(STATE, joints=home, openings={"right": 0.05, "left": 0.0}, received=3)
    link.says = [good, state]
    reports = states(cell)
    assert next(reports) is good
    with pytest.raises(ProtocolError, match="reports"):
        next(reports)
    assert link.is_closed

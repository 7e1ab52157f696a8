"""Vision only: poses in the maker's format, each once, and nothing of the motion is claimed."""

import threading
import time
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from pick_scenes import Sent, another, program
from ports import free_port
from waiting import PATIENCE, wait_until

from workbench.devices.pick_server.asking import Asker
from workbench.devices.pick_server.axes import axis_words
from workbench.devices.pick_server.conversation import POSES_VERSION, VERSION
from workbench.devices.pick_server.link import PickServer
from workbench.devices.pick_server.options import form_of
from workbench.formats.poses.conventions import CONVENTIONS, convention
from workbench.model.errors import CommandRefused, InputError, LinkError
from workbench.planning.kinematics.robot import Kinematics
from workbench.plugins.robot_link import controller_by, link_named
from workbench.testing import check_robot_link


def seeing(cell, poses="kuka", **options):
    """The cell with a server of poses at a port that nobody has."""
    options = {"longest": 128, "poses": poses, **options}
    return replace(cell, controller=controller_by("pick-server", port=free_port(), options=options))


class Asking:
    """A robot program that asks for poses."""

    def __init__(self, cell, run=1, version=POSES_VERSION):
        self.form, until = form_of(cell), time.monotonic() + PATIENCE
        self.over = threading.Event()

        def is_over():
            return self.over.is_set() or time.monotonic() > until

        port = cell.controller.port
        self.asker = Asker("127.0.0.1", port, self.form, run, is_over, 0.2, version=version)
        self.ask = self.asker.ask
        home = np.asarray(cell.arms[0].home)
        self.joints = axis_words(cell, self.form).format(home)

    def begin(self, *joints):
        while (answer := self.ask("next", *joints))[0] == "WAIT":
            time.sleep(0.005)
        return answer

    def poses(self):
        return [self.ask("pose", str(number)) for number in (1, 2, 3)]

    def close(self):
        self.over.set()
        self.asker.close()


@pytest.fixture
def offered(planned):
    """An offered pick: the cell, its sending, and the robot program."""
    cell, plan, approval = planned
    running = []

    def offer(number=0, run=1, **options):
        there = seeing(cell, **options)
        sent = Sent(there, plan, another(approval, number))
        running.append(Asking(there, run))
        return there, sent, running[-1]

    yield offer
    for robot in running:
        robot.close()


@pytest.mark.extensive
@pytest.mark.timeout(1800)
def test_it_keeps_the_promises_of_every_link(planned):
    cell, plan, approval = planned
    check_robot_link(PickServer(), seeing(cell), plan, approval)


@pytest.mark.parametrize("maker", CONVENTIONS)
@pytest.mark.parametrize(("frame", "pose_of"), [("base", "tcp"), ("world", "flange")])
def test_the_poses_are_those_of_the_plan_as_the_maker_writes_them(
    planned, offered, maker, frame, pose_of
):
    plan = planned[1]
    there, sent, robot = offered(poses=maker, frame=frame, pose_of=pose_of)
    # Where the robot stands decides nothing.
    pick = robot.begin()
    assert pick[:2] == ("PICK", "unproven")
    got = robot.poses()
    assert robot.ask("picked") == ("OK", "picked")
    assert robot.ask("placed") == ("OK", "end")
    receipts, error = sent.ended()
    assert error is None
    assert [receipt.part.is_picked for receipt in receipts if receipt.part] == [True]
    assert all("unproven" in r.sent for r in receipts if r.sent.startswith(("PICK", "POSE")))
    arm, legs = plan.arms[0], plan.arms[0]
    stops = [legs.leg("approach").q[0], legs.leg("approach").q[-1], legs.leg("extract").q[-1]]
    kinematics, written = Kinematics(there), convention(maker)
    names = [("approach", "open"), ("grasp", "grip"), ("retreat", "keep")]
    for words, q, (name, hand) in zip(got, stops, names, strict=True):
        assert words[:4] == ("POSE", "unproven", name, hand)
        T = kinematics.tcp_pose(there.arms[0], np.asarray(q))
        if frame == "base":
            T = there.T_world_robot.inverse() * T
        if pose_of == "flange":
            T = T * there.arm(arm.arm).tool.T_flange_tcp.inverse()
        shown = written.pose([float(word) for word in words[5:]])
        off = T.actInv(shown)
        assert np.abs(off.translation).max() < 1e-5
        assert np.linalg.norm(pin.log3(off.rotation)) < 3e-5


def test_the_retreat_is_not_the_approach(planned):
    arm = planned[1].arms[0]
    assert not np.allclose(arm.leg("extract").q[-1], arm.leg("approach").q[-1])


def test_a_program_for_paths_is_not_greeted_and_one_for_poses_gets_no_path(offered):
    there, sent, _ = offered()
    wrong = Asking(there, run=9, version=VERSION)
    with pytest.raises((LinkError, OSError)):
        wrong.asker._connect()
    wrong.close()
    right = Asking(there, run=10)
    assert right.begin()[0] == "PICK"
    right.poses()
    right.ask("failed", "unreachable")
    right.close()
    receipts, error = sent.ended()
    assert error is None
    assert [(r.part.is_picked, r.part.why) for r in receipts if r.part] == [(False, "unreachable")]


LIES = {
    "the second pose first": lambda r: r.ask("pose", "2"),
    "pose 0": lambda r: r.ask("pose", "0"),
    "a leg": lambda r: r.ask("leg", "1"),
    "a point": lambda r: r.ask("point", "1", "1"),
    "done": lambda r: r.ask("done", "1", *r.joints),
    "next once more": lambda r: r.ask("next"),
    "picked before the poses": lambda r: r.ask("picked"),
    "placed before the poses": lambda r: r.ask("placed"),
    "scan meanwhile": lambda r: r.ask("scan"),
    "its own stop": lambda r: r.ask("stop", "guard"),
    "impossible joints": lambda r: r.ask("state", *["9999.00"] * 6),
}

LATER_LIES = {
    "a pose again": lambda r: r.ask("pose", "3"),
    "a fourth pose": lambda r: r.ask("pose", "4"),
    "placed without picked": lambda r: r.ask("placed"),
    "another pick": lambda r: r.ask("next", *r.joints),
}


@pytest.mark.parametrize(
    ("number", "name"), list(enumerate((*LIES, *LATER_LIES))), ids=[*LIES, *LATER_LIES]
)
def test_a_lie_gets_no_pose_and_leaves_no_sending(offered, number, name):
    _, sent, robot = offered(number, run=number + 2, silence_s=1.0)
    robot.begin(*robot.joints)
    before = robot.poses() if name in LATER_LIES else []
    answer = (LIES | LATER_LIES)[name](robot)
    assert answer[0] in ("STOP", "ERR"), answer
    receipts, error = sent.ended()
    assert error is not None, "a lie brings no pick to its end"
    assert sum(receipt.sent.startswith("POSE") for receipt in receipts) == len(before)


def test_the_same_pose_twice_under_one_number_is_the_same_bytes(offered):
    _, sent, robot = offered()
    robot.begin()
    first = robot.ask("pose", "1")
    robot.asker._number -= 1
    assert robot.ask("pose", "1") == first
    robot.ask("failed")
    receipts, error = sent.ended()
    assert error is None
    assert sum(receipt.sent.startswith("POSE") for receipt in receipts) == 1


def test_an_approval_that_runs_out_before_the_first_pose_gives_none(planned):
    cell, plan, approval = planned
    there, late = seeing(cell), []

    def now():
        return approval.at + (1e9 if late else 0)

    sent, robot = Sent(there, plan, approval, now=now), Asking(there)
    robot.begin()
    late.append(True)
    assert robot.ask("pose", "1")[0] == "STOP"
    robot.close()
    assert isinstance(sent.ended()[1], CommandRefused)


def test_a_plan_that_nobody_has_approved_goes_out_as_poses_alone(planned):
    cell, plan, approval = planned
    unapproved = replace(approval, is_switched_off=True)
    assert unapproved.people == ()
    paths = replace(cell, controller=controller_by("pick-server", port=free_port()))
    receipts, error = Sent(paths, plan, unapproved).ended()
    assert receipts == [] and isinstance(error, CommandRefused)
    assert "nobody has approved" in str(error)
    there = seeing(cell)
    with program(there, port=there.controller.port) as robot:
        receipts, error = Sent(there, plan, unapproved).ended()
        assert error is None and len(robot.tickets) == 1


@pytest.mark.parametrize("fault", ["silent@2", "anew@2", "empty-hand@3", "cut@2"])
def test_faults_of_the_program_end_in_doubt_or_on_record(planned, fault):
    cell, plan, approval = planned
    there = seeing(cell, silence_s=1.0) if fault == "silent@2" else seeing(cell)
    with program(there, fault, port=there.controller.port):
        receipts, error = Sent(there, plan, approval).ended()
    if fault in ("silent@2", "anew@2"):
        assert isinstance(error, LinkError)
        assert sum(receipt.sent.startswith("POSE") for receipt in receipts) < 3
        return
    assert error is None
    assert [r.part.is_picked for r in receipts if r.part] == [fault == "cut@2"]


def test_stop_counts_at_the_next_request(planned):
    cell, plan, approval = planned
    there, stop = seeing(cell), []
    sent, robot = Sent(there, plan, approval, cancelled=lambda: bool(stop)), Asking(there)
    robot.begin()
    robot.ask("pose", "1")
    stop.append(True)
    wait_until(lambda: robot.ask("state")[0] == "STOP")
    assert robot.ask("pose", "2")[0] == "STOP"
    assert robot.ask("stop") == ("OK", "stop")
    robot.close()
    assert "acknowledged the stop" in str(sent.ended()[1])


@pytest.mark.parametrize(("maker", "longest", "fits"), [("kuka", 80, False), ("abb", 128, True)])
def test_lines_that_do_not_hold_every_pose_are_refused(planned, maker, longest, fits):
    cell = seeing(planned[0], maker, longest=longest)
    if fits:
        link_named("pick-server").check(cell)
        return
    with pytest.raises(InputError, match="poses do not fit"):
        link_named("pick-server").check(cell)

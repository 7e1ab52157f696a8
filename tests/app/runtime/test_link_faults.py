"""Everything that a controller can do wrong, over real TCP, through the bench, in both protocols.

After each: nothing was sent twice, nothing unapproved, the state says what happened, the robot
stands, and the journal holds every message.
"""

import dataclasses
import functools
import re
import threading
import time

import numpy as np
import pytest
from patient import PATIENT, Hurried
from ports import free_port
from waiting import PATIENCE, wait_until

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.outcomes import AcknowledgeFault
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.state import Phase
from workbench.app.picking.pipeline import plan_pick
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.robot_link import LinkRunner
from workbench.devices.abb_simulated import serve_program as abb_serve_program
from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.devices.abb_simulated.faults import FAULT_NAMES, parse_fault
from workbench.devices.abb_socket.messages import messages
from workbench.devices.abb_socket.program import lines_of, program_of
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.plugins.robot_link import Simulation, controller_by, spoken_to_by

OLD, NEW = "abb-socket", "abb-socket/2"


@pytest.fixture(scope="module")
def yumi():
    return read_cell("yumi")


@pytest.fixture(scope="module")
def found(yumi):
    floor = yumi.bin.T_world_bin.translation
    return tuple(
        Detection("keyed_cylinder", pose_from_rpy(floor + [0.0, y, 0.019], (np.pi / 2, 0.0, yaw)))
        for y, yaw in ((-0.07, 0.4), (0.07, -0.6))
    )


@pytest.fixture(scope="module")
def planned(yumi, found):
    """Plans by protocol and strategy, made once; both arms at once as the newer has them."""
    made = {
        (protocol, "alternated"): plan_pick(
            spoken_to_by(yumi, protocol), found, digest_of(found), strategy="alternated", seed=0
        )
        for protocol in (OLD, NEW)
    }
    both = plan_pick(yumi, found, digest_of(found), strategy="coordinated", seed=0)
    return made | {(protocol, "coordinated"): both for protocol in (OLD, NEW)}


@dataclasses.dataclass
class Rig:
    bench: Bench
    controller: SimulatedController
    clock: Hurried
    plan: object
    expected: list[str]

    @property
    def state(self):
        return self.bench.state

    @property
    def has_failed(self):
        return not self.controller._body.faults._left

    def send(self):
        self.bench.do(SendPlan(self.plan.digest), "ada")

    def ended(self):
        return self.bench.wait(lambda state: state.phase is not Phase.SENDING, PATIENCE)


@pytest.fixture
def rig(tmp_path, machines, yumi, found, planned):
    """A bench with an approved plan, beside a controller that will do something wrong."""
    made = []

    def build(protocol, *faults, speed=200.0, strategy="alternated", **patience):
        clock = Hurried()
        one = SimulatedController(yumi, Simulation(speed=speed, faults=faults), patience=PATIENT)
        thread = threading.Thread(target=one.run)
        thread.start()
        address = controller_by(protocol, "127.0.0.1", one.port, one.state_port)
        cell = dataclasses.replace(yumi, controller=address)
        ours = dataclasses.replace(PATIENT, clock=clock, **patience)
        effects = functools.partial(machines, patience=ours)
        bench = Bench(cell, Journal(tmp_path / "session"), effects=effects)
        made.append((bench, one, thread))
        bench.do(UseDetections(found), "ada")
        number = bench.do(MakePlan(), "ada").number
        bench.do(JobEnded(number, planned[protocol, strategy]), "worker")
        plan = planned[protocol, strategy].plan
        bench.do(WatchPlan(plan.digest), "ada")
        bench.do(Approve(plan.digest), "ada")
        wait_until(lambda: bench.live.joints)
        if protocol == OLD:
            expected = [message.text for message in messages(cell, plan)]
        else:
            program = program_of(cell, plan, bench.state.approval)
            expected = [f"{line.word} {line.rest}" for line in lines_of(cell, program)]
        return Rig(bench, one, clock, plan, expected)

    yield build
    for bench, one, thread in made:
        bench.close()
        one.stop()
        thread.join(PATIENCE)
        assert not thread.is_alive()


def check_evidence(rig, protocol):
    """What holds after every end, good or bad."""
    state = rig.state
    sent = [receipt.sent for receipt in state.receipts if receipt.sent]
    if protocol == OLD:
        assert sent == rig.expected[: len(sent)]
    else:
        assert len(set(sent)) == len(sent)
        numbers = [int(text[:4]) for text in sent]
        assert numbers == list(range(1, len(sent) + 1))
        said = [text[5:] for text in sent[1:] if text[5:].split()[0] not in ("end", "run")]
        assert said == rig.expected[: len(said)]
    entries = list(replay(rig.bench._journal, rig.bench.cell))
    kinds = [type(entry.command).__name__ for entry, _ in entries]
    assert kinds.count("Sent") == len(state.receipts)
    assert kinds.count("SendPlan") == kinds.count("LinkEnded") == 1
    assert kinds.index("Approve") < kinds.index("SendPlan")
    last = next(entry.command for entry, _ in reversed(entries) if entry.actor == "robot link")
    assert str(last.fault) == str(state.fault)
    assert digest_of(last.parts) == digest_of(state.part_reports)
    assert [part.arm for part in state.part_reports] == [one.arm for one in rig.plan.arms]
    wait_until(lambda: rig.controller.state()["moving"] == "")


FAULTS = [
    (OLD, "drop:5", 200, "(closed the link|broke) at message 6"),
    (NEW, "drop:5", 200, "(closed the link|broke) at message 6"),
    (NEW, "drop:98", 0.5, "(closed the link|broke) at step"),
    (OLD, "garbage:5", 200, "where one b'send' was expected"),
    (NEW, "garbage:5", 200, "does not begin like a frame|is not text"),
    (NEW, "slow:5", 200, "did not acknowledge '0005 "),
    (OLD, "half-open:5", 200, f"silent for {PATIENCE:.1f} s at message 6"),
    (NEW, "half-open:5", 200, "did not acknowledge '0005 "),
    (NEW, "half-open:98", 0.5, r"did not acknowledge '\d+ ping'|was silent"),
    (OLD, "double-send:5", 200, "b'sendsend' where one"),
    (NEW, "double-send:5", 200, r"frame 0\d+ came where 0\d+ was expected"),
    (OLD, "wrong-arm:2", 0.1, r"moves arm (left|right), the order was for arm (?!\1)\w+"),
    (
        NEW,
        "wrong-arm:1",
        0.1,
        r"arm (left|right) goes to waypoint .* in step 1; the plan moves (?!\1)",
    ),
    (OLD, "emergency-stop:3", 200, "reports a fault: emergency stop"),
    (NEW, "emergency-stop:3", 200, "reports a fault at step .*: emergency stop"),
    (OLD, "pointer-lost:3", 200, "the program pointer of an arm is lost"),
    (NEW, "pointer-lost:3", 200, "the program pointer of an arm is lost"),
    (OLD, "start-refused", 200, "from its start"),
    (NEW, "start-refused", 200, "refuses message .*: an arm is 12.3 degrees from its start"),
]


SAID_BY_REPORTS = {
    (OLD, "half-open:5"): {"report": 0.0},
    (OLD, "emergency-stop:3"): {"doubt": 0.0},
    (OLD, "pointer-lost:3"): {"doubt": 0.0},
}
"""Who says nothing on the link any more is not waited for there, and one who reports nothing either
is not waited for at all."""


@pytest.mark.parametrize(
    ("protocol", "fault", "speed", "says"), FAULTS, ids=[f"{p}-{f}" for p, f, _, _ in FAULTS]
)
def test_a_fault_of_the_controller(rig, monkeypatch, protocol, fault, speed, says):
    # A slow controller is so until the silence was noticed.
    monkeypatch.setattr(abb_serve_program, "SLOW_SECONDS", PATIENCE)
    one = rig(protocol, fault, speed=speed, **SAID_BY_REPORTS.get((protocol, fault), {}))
    one.send()
    if fault.startswith(("slow", "half-open")):
        wait_until(lambda: one.has_failed)
        wait_until(lambda: one.clock.let_pass(PATIENCE) or one.state.phase is not Phase.SENDING)
    state = one.ended()
    assert state.phase is Phase.FAULT
    assert re.search(says, str(state.fault)), state.fault
    check_evidence(one, protocol)
    assert state.parts_placed <= sum(part.is_picked is not False for part in state.part_reports)
    # Not again: not now, not after the fault is acknowledged, without a scan and a new approval.
    for _ in range(2):
        with pytest.raises(CommandRefused):
            one.send()
        if one.state.phase is Phase.FAULT:
            one.bench.do(AcknowledgeFault(), "ada")
    assert one.bench.live.link.phase == "closed"


def test_every_fault_is_tried():
    names = {parse_fault(fault).name for _, fault, _, _ in FAULTS}
    assert names | {"empty-hand"} == set(FAULT_NAMES)


@pytest.mark.parametrize("text", ["drop:0", "drop:x", "fire", "drop:", "drop:12345"])
def test_an_unknown_fault_is_refused(text):
    with pytest.raises(InputError, match="is not known: one of drop"):
        parse_fault(text)


def test_the_older_protocol_bears_a_slow_controller(rig):
    one = rig(OLD, "slow:5")
    one.send()
    state = one.ended()
    assert (state.phase, state.parts_placed) == (Phase.DONE, 2)
    check_evidence(one, OLD)
    assert {part.is_picked for part in state.part_reports} == {None}


@pytest.mark.parametrize("strategy", ["alternated", "coordinated"])
def test_a_good_cycle_tells_of_every_part(rig, strategy):
    one = rig(NEW, "empty-hand:1", strategy=strategy)
    one.send()
    state = one.ended()
    assert (state.phase, state.parts_placed) == (Phase.DONE, 1)
    check_evidence(one, NEW)
    assert sorted(part.is_picked for part in state.part_reports) == [False, True]
    assert "arm failed: closed to 0.0 mm where" in str(state.message)
    assert {part.detection for part in state.part_reports} == {0, 1}


def test_both_arms_at_once_are_refused_by_a_protocol_that_cannot_say_it(rig):
    with pytest.raises(CommandRefused, match="or use a robot link that moves two"):
        rig(OLD, strategy="coordinated")


def test_joints_that_only_the_link_reports_are_not_shown_once_it_is_closed(rig):
    one = rig(NEW, speed=20)
    port = free_port()
    silent = dataclasses.replace(one.bench.cell.controller, state_port=port)
    told, shown, moved = [], {}, []

    def show(**changes):
        shown.update(changes)
        moved.append(bool(shown.get("joints")))

    link = LinkRunner(
        dataclasses.replace(one.bench.cell, controller=silent),
        lambda command, actor: told.append(command),
        time.time,
        show,
        patience=PATIENT,
    )
    link.send(one.plan, one.state.approval)
    wait_until(lambda: any(isinstance(command, LinkEnded) for command in told))
    link.close()
    assert any(moved), "while it was sent the joints were shown"
    assert shown["joints"] == {}, "nobody knows where the robot is moved to from now on"


@pytest.mark.parametrize("protocol", [OLD, NEW])
def test_a_stop_while_the_robot_moves(rig, protocol):
    one = rig(protocol, speed=0.5)
    one.send()
    wait_until(lambda: one.controller.state()["moving"] == "right")
    one.bench.do(Stop(), "ada")
    state = one.ended()
    assert state.phase is Phase.FAULT and "sending was stopped" in str(state.fault)
    if protocol == NEW:
        assert "the controller acknowledged the stop after" in str(state.fault)
        assert state.receipts[-1].heard.endswith("stopped")
    check_evidence(one, protocol)
    link = one.bench.live.link
    assert link.stopped is not None and link.stop
    where = one.controller.state()["joints"]
    time.sleep(0.3)
    assert one.controller.state()["joints"] == where


def test_one_approval_is_good_for_one_sending(rig):
    """Even when somebody gets past the rules."""
    one = rig(OLD)
    told = []
    link = LinkRunner(
        one.bench.cell,
        lambda command, actor: told.append(command),
        time.time,
        lambda **_: None,
        patience=PATIENT,
    )
    for number in (1, 2):
        link.send(one.plan, one.state.approval)
        wait_until(lambda number=number: sum(isinstance(c, LinkEnded) for c in told) == number)
    link.close()
    assert [str(c.fault or "") for c in told if isinstance(c, LinkEnded)] == [
        "",
        "this approval has been used; have the plan approved again",
    ]
    assert one.controller.state()["received"] == len(one.expected)

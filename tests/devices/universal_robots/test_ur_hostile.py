"""A controller of Universal Robots whose reports cannot be, and programs that come twice."""

import math
import socket
import struct
import time
from contextlib import contextmanager
from dataclasses import replace

import pytest
from relays import as_it_is, between_streams
from twins import PATIENT, approved_for, own_host, twin_of
from waiting import wait_until

from workbench.devices.universal_robots import rtde
from workbench.devices.universal_robots.program import ProgramSettings, program_of
from workbench.devices.universal_robots.twin import DASHBOARD_PORT
from workbench.model.errors import JobCancelled, LinkError
from workbench.plugins.robot_link import send, states

pytest.importorskip(
    "rtde_receive", reason="ur-rtde is not installed: pip install 'workbench[ur-rtde]'"
)

SCRIPTS, RTDE, BOARD = range(3)
"""Ports of the controller, in the order in which they are listened to."""


@pytest.fixture(scope="module")
def planned():
    return approved_for("ur-rtde")


class Packets:
    """RTDE on one connection, packet by packet: each state may be told otherwise."""

    def __init__(self, spoil):
        self._spoil, self._heard, self._said, self._names = spoil, b"", b"", []

    def heard(self, data):
        out = b""
        self._heard, packets = self._cut(self._heard + data)
        for kind, content in packets:
            if kind != rtde.DATA or not self._names:
                out += rtde.packet(kind, content)
                continue
            state = self._unpacked(content[1:])
            for told in self._spoil(state):
                made = told
                if isinstance(told, dict):
                    made = rtde.packet(kind, content[:1] + rtde.pack_values(self._names, told))
                out += made
        return [out] if out else []

    def said(self, data):
        self._said, packets = self._cut(self._said + data)
        for kind, content in packets:
            if kind == rtde.OUTPUTS:
                self._names = [name for name in content[8:].decode().split(",") if name]
        return [data]

    def _unpacked(self, data):
        state, at = {}, 0
        for name in self._names:
            form = struct.Struct(">" + rtde.FORMATS[rtde.type_of(name)])
            value = form.unpack_from(data, at)
            state[name], at = value if len(value) > 1 else value[0], at + form.size
        return state

    def _cut(self, data):
        packets = []
        while len(data) >= rtde.HEADER.size:
            size, kind = rtde.HEADER.unpack_from(data)
            if len(data) < size:
                break
            packets.append((kind, data[rtde.HEADER.size : size]))
            data = data[size:]
        return data, packets


PROGRESS = f"output_int_register_{rtde.PROGRESS}"


@contextmanager
def spoilt_twin(cell, spoil=None, scripts=None, board=None, **given):
    """The twin, and the cell with its controller behind somebody who changes what is said.

    `spoil(state)` gives the states, or bytes, that come in place of one; `scripts(data)` what
    comes to the controller in place of a program, `board(data)` what its dashboard answers.
    """
    theirs, ours = own_host(), own_host()
    with twin_of(cell, theirs, **given) as (twin, there):
        to = [(theirs, there.controller.port), (theirs, rtde.RTDE_PORT), (theirs, DASHBOARD_PORT)]

        def made(k):
            heard, said = as_it_is()
            if k == RTDE and spoil is not None:
                packets = Packets(spoil)
                heard, said = packets.heard, packets.said
            if k == SCRIPTS and scripts is not None:
                said = scripts
            if k == BOARD and board is not None:
                heard = board
            return heard, said

        ports = (0, rtde.RTDE_PORT, DASHBOARD_PORT)
        with between_streams(ours, to, ports, made) as (ports, cut):
            at = replace(there.controller, host=ours, port=ports[SCRIPTS])
            twin.cut, twin.host = cut, theirs
            yield twin, replace(there, controller=at)


class InLeg:
    """Spoils all states from the `into`-th in a leg on."""

    def __init__(self, how, leg=2, into=2):
        self._how, self._leg, self._into, self.count = how, leg, into, 0

    def __call__(self, state):
        self.count += state[PROGRESS] % rtde.TICKETS >= self._leg
        return self._how(state) if self.count >= self._into else [state]


def with_axis(state, value):
    return state | {"actual_q": (*state["actual_q"][:2], value, *state["actual_q"][3:])}


def fault_of(planned, spoil, says, speed=2.0, patience=PATIENT, **given):
    cell, plan, approval = planned
    kinds = []
    with spoilt_twin(cell, spoil, speed=speed, **given) as (twin, there):
        with pytest.raises(LinkError, match=says):
            for receipt in send(plan, approval, there, patience=patience):
                kinds.append(receipt.kind)
        assert "end" not in kinds
        wait_until(lambda: not twin.is_playing, "the robot to stop")
    return kinds


IMPOSSIBLE = [1e308, -1e308, math.nan, math.inf, -math.inf, 20.0, 1e7]


@pytest.mark.parametrize("value", IMPOSSIBLE)
def test_a_joint_that_is_reported_where_it_cannot_be_ends_the_motion(planned, value):
    says = r"reports joint_3 (at -?\S+ degrees; it goes from|as \S+, which is no finite number)"
    fault_of(planned, InLeg(lambda state: [with_axis(state, value)]), says)


@pytest.mark.parametrize("at", [math.nan, math.inf, -math.inf, -1.0, 1e308])
def test_a_time_that_cannot_be_ends_the_motion(planned, at):
    says = r"reports a time (of \S+ s|as \S+, which is no finite number)"
    fault_of(planned, InLeg(lambda state: [state | {"timestamp": at}]), says)


def test_a_clock_that_goes_back_ends_the_motion(planned):
    back = InLeg(lambda state: [state | {"timestamp": state["timestamp"] - 100.0}])
    fault_of(planned, back, r"clock goes back, from \S+ to \S+ s")


def test_a_clock_that_stands_is_silence(planned):
    stands = InLeg(lambda state: [state | {"timestamp": 1e6}])
    patience = replace(PATIENT, silence=2.0)
    fault_of(planned, stands, r"silent for 2.0 s at leg [12] of 6", patience=patience)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda leg: leg + 7 * rtde.TICKETS, "reports another program at leg"),
        (lambda leg: -(2**31), "reports another program at leg"),
        (lambda leg: 2**31 - 1, "reports another program at leg"),
        (lambda leg: 0, "reports another program at leg"),
        (lambda leg: leg - 1, "is in leg 1 after leg 2 of 6"),
        (lambda leg: leg + 2, r"is in leg 4 0\.\d\d s after leg [12]: what is between takes"),
        (lambda leg: leg + 5, r"is at the end 0\.\d\d s after leg [12]: what is between takes"),
    ],
)
def test_a_leg_out_of_turn_ends_the_motion(planned, change, says):
    fault_of(planned, InLeg(lambda state: [state | {PROGRESS: change(state[PROGRESS])}]), says)


def test_an_end_that_comes_at_once_is_no_end(planned):
    cell, plan, approval = planned
    program = program_of(cell, plan, approval, ProgramSettings(0, 0.5, 2.0))
    end = tuple(cell.arms[0].to_axes(program.q_end).tolist())

    def over(state):
        told = {PROGRESS: program.end, "runtime_state": rtde.STOPPED, "actual_q": end}
        return [state | told] if state[PROGRESS] >= program.ticket else [state]

    kinds = fault_of(planned, over, "is at the end .* after the beginning: what is between takes")
    assert kinds == ["program"]


@pytest.mark.parametrize(
    ("told", "says"),
    [
        ({"safety_status_bits": 1 << 2}, r"reports a fault at leg [12] of 6: protective stop"),
        (
            {"safety_status_bits": 0xFFFFFFFF},
            r"reports a fault at leg [12] of 6: protective stop, recovery",
        ),
        ({"robot_mode": 5}, r"reports a fault at leg [12] of 6: the robot is idle"),
        ({"robot_mode": -(2**31)}, "the robot is in mode -2147483648"),
        ({"runtime_state": 77}, r"ended the program at leg \d of 6"),
        ({"runtime_state": rtde.STOPPED}, r"ended the program at leg \d of 6"),
    ],
)
def test_a_state_in_which_a_robot_does_not_move_ends_the_motion(planned, told, says):
    fault_of(planned, InLeg(lambda state: [state | told]), says)


@pytest.mark.parametrize(
    "instead",
    [[], [b"\x00\x03\xff"], [b"\xff" * 5000], [b"\x00\x00\x00"], [b"\x00\x40\x55\x01half"]],
    ids=["nothing", "a packet of no kind", "noise", "no length", "half a packet"],
)
def test_packets_that_are_none_end_the_motion(planned, instead):
    says = r"silent for 3\.0 s|has ended|client of the controller|protocol error"
    patience = replace(PATIENT, silence=3.0)
    fault_of(planned, InLeg(lambda state: instead), says, patience=patience)


def test_states_that_come_many_times_over_make_no_difference(planned):
    cell, plan, approval = planned
    with spoilt_twin(cell, lambda state: [state] * 30, speed=4.0) as (_, there):
        receipts = list(send(plan, approval, there, patience=PATIENT))
    assert receipts[-1].kind == "end"


def plans(twin):
    return [text for text in twin.programs if "workbench_plan" in text]


def leg_of(twin):
    return twin._registers[rtde.PROGRESS] % rtde.TICKETS


def come_again(twin, text):
    """The program comes to the controller once more, which nobody has approved."""
    count = len(plans(twin))
    with socket.create_connection((twin.host, twin.port)) as link:
        link.sendall(text.encode())
        wait_until(lambda: len(plans(twin)) > count and leg_of(twin) == rtde.REFUSED)
    wait_until(lambda: not twin.is_playing)


@pytest.mark.parametrize("leg", [1, 2, 5])
def test_a_program_that_comes_twice_is_not_begun_again_and_the_motion_ends(planned, leg):
    cell, plan, approval = planned
    with spoilt_twin(cell, speed=0.5) as (twin, there):
        sending = send(plan, approval, there, patience=PATIENT)
        text, kinds = next(sending).sent, []
        with pytest.raises(LinkError, match=r"came to the controller twice, at leg \d of 6"):
            for receipt in sending:
                kinds.append(receipt.kind)
                if len(kinds) == leg:
                    come_again(twin, text)
                    stood = twin.q
        assert "end" not in kinds and twin.q == stood


def test_a_program_that_comes_once_more_after_its_end_moves_nothing(planned):
    cell, plan, approval = planned
    with spoilt_twin(cell, speed=50.0) as (twin, there):
        text = next(iter(list(send(plan, approval, there, patience=PATIENT)))).sent
        # Nor with others between: the last four are remembered.
        for earlier in (1, 2, 3):
            other = replace(approval, at=approval.at - earlier)
            list(send(plan, other, there, patience=PATIENT))
            stood, outputs = twin.q, dict(twin.outputs)
            twin.outputs.clear()
            come_again(twin, text)
            assert twin.q == stood and twin.outputs == {}
            twin.outputs.update(outputs)
        with pytest.raises(LinkError, match="has begun this plan already; nothing runs twice"):
            list(send(plan, approval, there, patience=PATIENT))
        assert len(plans(twin)) == 4 + 3


def test_a_program_that_is_doubled_on_the_way_moves_the_robot_once_at_most(planned):
    cell, plan, approval = planned
    program = program_of(cell, plan, approval, ProgramSettings(0, 0.5, 2.0))

    def doubled(data):
        return [data, data] if b"workbench_plan" in data and data.endswith(b"\nend\n") else [data]

    with spoilt_twin(cell, scripts=doubled, speed=20.0) as (twin, there):
        begun = []
        write = twin._write
        twin._write = lambda *words: (begun.append(words[1]), write(*words))
        try:
            receipts = list(send(plan, approval, there, patience=PATIENT))
        except LinkError as error:
            assert "came to the controller twice" in str(error)
        else:
            assert receipts[-1].kind == "end"
        assert len(plans(twin)) == 2
        assert begun.count(str(program.ticket + 1)) <= 1


PHASES = {
    "before anything": lambda twin, receipts: True,
    "once the program is out": lambda twin, receipts: len(receipts) == 1,
    "while the hand moves": lambda twin, receipts: leg_of(twin) == 3,
    "in a leg": lambda twin, receipts: leg_of(twin) == 2,
    "in the last one": lambda twin, receipts: len(receipts) == 7,
}


@pytest.mark.parametrize("phase", PHASES)
def test_a_stop_in_each_phase_leaves_a_robot_that_stands(planned, phase):
    cell, plan, approval = planned
    receipts = []
    with spoilt_twin(cell, speed=0.5 if "last" not in phase else 2.0) as (twin, there):
        sending = send(
            plan,
            approval,
            there,
            cancelled=lambda: PHASES[phase](twin, receipts),
            patience=PATIENT,
        )
        says = "reported that it stands after"
        if phase == "before anything":
            says = "stopped before the controller was spoken to"
        with pytest.raises(JobCancelled, match=says):
            for receipt in sending:
                receipts.append(receipt)
        stood = twin.q
        assert not twin.is_playing and "end" not in [one.kind for one in receipts]
        assert len(plans(twin)) == (phase != "before anything")
        time.sleep(0.1)
        assert twin.q == stood and not twin.is_playing


def test_a_link_that_is_cut_and_comes_back_goes_on_with_nothing(planned):
    cell, plan, approval = planned
    with spoilt_twin(cell, speed=0.3) as (twin, there):
        sending = send(plan, approval, there, patience=replace(PATIENT, silence=2.0))
        with pytest.raises(LinkError):
            for receipt in sending:
                if receipt.kind == "reach":
                    twin.cut.set()
        wait_until(lambda: not twin.is_playing, "the robot to stop")
        twin.cut.clear()
        stood = twin.q
        # It is away from where the plan begins, and would not run it again there either.
        with pytest.raises(
            LinkError, match=r"cannot move: protective stop|run this program already"
        ):
            list(send(plan, approval, there, patience=PATIENT))
        assert twin.q == stood and len(plans(twin)) == 1


@pytest.mark.parametrize(
    "answer", [b"x" * 100_000, b"\xff\x00\n", b""], ids=["long", "noise", "none"]
)
def test_a_dashboard_that_answers_nonsense_lets_nothing_out(planned, answer):
    cell, plan, approval = planned
    with spoilt_twin(cell, board=lambda data: [answer] if answer else []) as (twin, there):
        with pytest.raises(LinkError):
            list(send(plan, approval, there, patience=replace(PATIENT, answer=5.0)))
        assert plans(twin) == []


@pytest.mark.parametrize("value", IMPOSSIBLE)
def test_a_state_that_cannot_be_is_not_handed_on(planned, value):
    cell, _, _ = planned
    seen = []

    def spoil(state):
        seen.append(state)
        return [with_axis(state, value)] if len(seen) > 20 else [state]

    with spoilt_twin(cell, spoil) as (_, there):
        reports = states(there)
        assert next(reports).fault == ""
        with pytest.raises(LinkError, match="reports joint_3 "):
            next(reports)

"""abb-socket/2 over real TCP: what is executed is what was proven, however bytes and arms go."""

import itertools
import json
import random
import select
import socket
import threading
import time
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from blend_curves import RoundedPolyline
from patient import PATIENT, Hurried, send
from waiting import PATIENCE, wait_until

from workbench.app.picking.pipeline import plan_pick
from workbench.devices.abb_links import AbbProgram
from workbench.devices.abb_socket import link
from workbench.devices.abb_socket.frames import make_frame
from workbench.devices.abb_socket.messages import REQUEST
from workbench.model.errors import JobCancelled, LinkError
from workbench.model.plan import Guarantee
from workbench.plugins.robot_link import USUAL

SAMPLES = 200
"""Of the proven curve, between two waypoints."""


@pytest.fixture(scope="module")
def both(cell, plan):
    return plan_pick(cell, plan.detections, "scan", strategy="coordinated", seed=0).plan


def led(start, end):
    """Four configurations on a straight line, in the steps that the link can send."""
    q = start + np.array([0.0, 0.3, 0.6, 1.0])[:, None] * (end - start)
    return AbbProgram.motion.rounded(q)


@pytest.fixture(scope="module")
def in_step(both):
    """The legs of a step at the same times, as in a synchronised plan."""
    runs = [run for step in both.sequence if len(step.runs) == 2 for run in step.runs]
    arms = []
    for one in both.arms:
        legs = [
            replace(leg, q=led(leg.q[0], leg.q[-1]), t=np.array([0.0, 0.8, 1.7, 2.5]))
            if (one.arm, leg.name) in runs
            else leg
            for leg in one.legs
        ]
        arms.append(replace(one, legs=tuple(legs)))
    return replace(both, arms=tuple(arms), guarantee=Guarantee.SYNCHRONISED)


@contextmanager
def splitting(port, seed):
    """A way to a port on which all bytes come in other pieces than they were sent."""
    rng = random.Random(seed)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def forward(source, target):
            while True:
                try:
                    data = source.recv(4096)
                    while data:
                        count = rng.randint(1, 60)
                        target.sendall(data[:count])
                        data = data[count:]
                        if rng.random() < 0.3:
                            time.sleep(0.0005)
                    if not data and not source.getpeername():
                        return
                except OSError:
                    return

        def serve():
            ours, _ = server.accept()
            theirs = socket.create_connection(("127.0.0.1", port))
            for one in (ours, theirs):
                one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            sockets.extend((ours, theirs))
            threading.Thread(target=forward, args=(ours, theirs), daemon=True).start()
            threading.Thread(target=forward, args=(theirs, ours), daemon=True).start()

        sockets: list[socket.socket] = []
        accepting = threading.Thread(target=serve, daemon=True)
        accepting.start()
        yield server.getsockname()[1]
        accepting.join(PATIENCE)
        for one in sockets:
            one.close()


def approval_of(approval, plan, cell):
    return replace(approval, plan_digest=plan.digest, cell_digest=cell.digest)


def proven(cell, plan, arm, name):
    """The curve of a leg, densely: parameters and configurations."""
    q = np.asarray(plan.arm(arm).leg(name).q)
    s = np.linspace(0, len(q) - 1, (len(q) - 1) * SAMPLES + 1)
    return s, RoundedPolyline(q, cell.policy.zone)(s)


@pytest.mark.parametrize(
    ("which", "paces"),
    [
        ("plan", {}),
        ("both", {}),
        ("both", {"right": 0.5}),
        ("both", {"left": 0.4, "right": 1.3}),
        ("in_step", {"left": 0.5}),
    ],
)
def test_what_is_executed_is_what_was_proven(
    request, controller, cell, at, approval, tmp_path, which, paces
):
    plan = request.getfixturevalue(which)
    one = controller(trace=tmp_path / "trace.jsonl", paces=paces)
    target = at(one.port, protocol="abb-socket/2")
    receipts = list(send(plan, approval_of(approval, plan, target), target))
    assert [receipt.part.is_picked for receipt in receipts if receipt.part] == [True, True]
    states = [json.loads(line) for line in (tmp_path / "trace.jsonl").read_text().splitlines()]
    numbers = [state["step"] for state in states]
    assert numbers == sorted(numbers) and set(numbers) == set(range(1, len(plan.sequence) + 1))
    stands = {arm.name: np.asarray(arm.home) for arm in cell.arms}
    for number, step in enumerate(plan.sequence, start=1):
        mine = [state for state in states if state["step"] == number]
        where = {}
        for arm in stands:
            q = np.array([state["q"][arm] for state in mine])
            names = [name for moving, name in step.runs if moving == arm]
            if not names:
                # Who has no leg in a step stands where its last one ended.
                np.testing.assert_allclose(q, np.tile(stands[arm], (len(q), 1)), atol=1e-9)
                continue
            s, curve = proven(cell, plan, arm, names[0])
            apart = np.abs(q[:, None, :] - curve[None]).max(axis=2)
            spacing = np.abs(np.diff(curve, axis=0)).max()
            assert apart.min(axis=1).max() <= spacing
            where[arm] = s[apart.argmin(axis=1)]
            assert np.all(np.diff(where[arm]) >= -2 / SAMPLES), "an arm goes back on its way"
            # All arms arrive before the next step begins.
            np.testing.assert_allclose(q[-1], curve[-1], atol=1e-6)
            leg = plan.arm(arm).leg(names[0])
            assert {state["openings"][arm] for state in mine} == {leg.opening}
            stands[arm] = np.asarray(leg.q[-1])
        if which == "in_step" and len(where) == 2:
            np.testing.assert_allclose(*where.values(), atol=2 / SAMPLES)
    for arm in cell.arms:
        np.testing.assert_allclose(stands[arm.name], arm.home, atol=1e-4)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("protocol", ["abb-socket", "abb-socket/2"])
def test_bytes_may_be_split_anywhere(
    controller, at, plan, waypoints, approval, tmp_path, protocol, seed
):
    one = controller()
    with splitting(one.port, seed) as port:
        receipts = list(send(plan, approval, at(port, protocol=protocol)))
    assert receipts[-1].done == receipts[-1].total
    arrived = [json.loads(line) for line in (tmp_path / "arrived.jsonl").read_text().splitlines()]
    assert [line["arm"] for line in arrived] == [arm for arm, _ in waypoints]
    np.testing.assert_allclose(
        [line["q"] for line in arrived], [q for _, q in waypoints], atol=1e-9
    )
    assert one.state()["placed"] == 2


def test_a_hand_that_took_nothing_is_told(controller, at, plan, approval):
    one = controller(faults=["empty-hand:2"])
    receipts = list(send(plan, approval, at(one.port, protocol="abb-socket/2")))
    parts = [receipt.part for receipt in receipts if receipt.part]
    assert [part.is_picked for part in parts] == [True, False]
    assert parts[1].why.startswith("closed to 0.0 mm where ")
    assert [part.is_missed for part in parts] == [False, True]
    assert one.state()["placed"] == 1


def test_the_same_approval_moves_the_robot_once(controller, at, plan, approval):
    one = controller()
    target = at(one.port, protocol="abb-socket/2")
    list(send(plan, approval, target))
    with pytest.raises(LinkError, match=f"ticket {approval.digest[:16]} was run before"):
        list(send(plan, approval, target))
    list(send(plan, replace(approval, at=approval.at - 1), target))
    assert one.state()["placed"] == 4


def test_a_controller_of_the_older_protocol_is_told_apart(at, plan, approval):
    """It closes the link on what it does not know; nothing but the greeting went out."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        got: list[bytes] = []

        def old():
            client, _ = server.accept()
            with client:
                client.sendall(b"send")
                got.append(client.recv(256))

        thread = threading.Thread(target=old)
        thread.start()
        port = server.getsockname()[1]
        with pytest.raises(LinkError, match="perhaps it speaks an older protocol"):
            list(send(plan, approval, at(port, protocol="abb-socket/2")))
        thread.join(PATIENCE)
    assert got[0].startswith(b"0001 hello abb-socket/2") and len(got[0]) == 80


def test_a_stop_is_acknowledged_while_the_robot_moves(controller, at, plan, approval):
    one = controller(speed=0.05)
    moving = threading.Event()
    shown: list = []

    def show(status):
        shown.append(status)
        if status.phase == "running" and status.step >= 1:
            moving.set()

    target = at(one.port, protocol="abb-socket/2")
    with pytest.raises(JobCancelled, match=r"stopped at step \d+ of 12; the controller acknow"):
        list(send(plan, approval, target, cancelled=moving.is_set, show=show))
    assert shown[-1].stopped is not None and shown[-1].phase == "stopped"
    state = one.state()
    assert (state["moving"], state["fault"]) == ("", "stopped by the client")
    time.sleep(0.2)
    assert one.state()["joints"] == state["joints"]


def test_a_client_that_falls_silent_stops_the_robot(controller, cell, at, plan, approval):
    """The link stays open; nobody says anything on it any more."""
    clock = Hurried()
    one = controller(speed=0.05, patience=replace(USUAL, clock=clock))
    receipts = send(plan, approval, at(one.port, protocol="abb-socket/2"))
    for receipt in receipts:
        if receipt.kind == "run":
            break
    clock.let_pass(USUAL.silence)
    wait_until(lambda: one.state()["fault"])
    assert "the client was silent for 2 s while the robot moved" in one.state()["fault"]
    with pytest.raises(LinkError):
        list(receipts)


def test_a_process_that_stood_still_hears_first_what_has_come_meanwhile(
    controller, at, plan, approval, monkeypatch
):
    clock, stood_still = Hurried(), []
    received = link._receive

    def stand_still(ours, talk):
        data = received(ours, talk)
        if not data and talk.status.step and not stood_still:
            clock.let_pass(2 * PATIENT.silence)
            stood_still.append(select.select([ours], [], [], PATIENCE)[0])
        return data

    monkeypatch.setattr(link, "_receive", stand_still)
    one = controller(speed=0.5)
    target = at(one.port, protocol="abb-socket/2")
    *_, last = send(plan, approval, target, patience=replace(PATIENT, clock=clock))
    assert stood_still != [] and "done" in last.heard


def test_a_robot_that_has_much_to_catch_up_with_is_heard_of_meanwhile(
    controller, at, plan, approval
):
    """As on a machine that does not get round to it for seconds."""
    seconds = itertools.count()
    patience = replace(PATIENT, silence=1e9, clock=lambda: float(next(seconds)))
    one = controller(speed=1000.0, patience=patience)
    steps: list[int] = []
    target = at(one.port, protocol="abb-socket/2")
    list(send(plan, approval, target, show=lambda status: steps.append(status.step)))
    # How many of the steps on the way depends on how often we get round to hear it.
    assert len(set(steps) - {0, len(plan.sequence)}) > 1


def test_what_is_said_while_we_are_busy_is_no_silence(at, plan, approval):
    clock, busy, told = Hurried(), threading.Event(), threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            client, _ = server.accept()
            with client:
                client.sendall(REQUEST)
                client.recv(256)
                client.sendall(make_frame(1, "hello abb-socket/2 R7 L7"))
                busy.wait(PATIENCE)
                client.sendall(make_frame(2, "state ready 00 R00 L00"))
                told.set()
                client.recv(256)

        thread = threading.Thread(target=serve)
        thread.start()
        target = at(server.getsockname()[1], protocol="abb-socket/2")
        receipts = send(plan, approval, target, patience=replace(PATIENT, clock=clock))
        assert next(receipts).kind == "hello"
        busy.set()
        assert told.wait(PATIENCE)
        clock.let_pass(2 * PATIENCE)
        with pytest.raises(LinkError, match="closed the link at message 2"):
            list(receipts)
        thread.join(PATIENCE)

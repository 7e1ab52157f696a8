"""Sending over real TCP: what arrives, what is refused, and every way it can break."""

import json
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from patient import PATIENT, send
from waiting import PATIENCE, wait_until

from workbench.devices.abb_simulated.controller import MOST_WATCHERS
from workbench.devices.abb_socket.messages import messages
from workbench.devices.abb_socket.reports import watch_state
from workbench.model.errors import CommandRefused, JobCancelled, LinkError, ProtocolError


@contextmanager
def controller_that(behaves) -> Iterator[tuple[int, list[bytes]]]:
    """A server for one client that does what `behaves(client, got)` says; the bytes it got."""
    got: list[bytes] = []
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(PATIENCE)

        def serve() -> None:
            try:
                client, _ = server.accept()
            except TimeoutError:
                return
            with client:
                client.settimeout(PATIENCE)
                behaves(client, got)

        thread = threading.Thread(target=serve)
        thread.start()
        yield server.getsockname()[1], got
        thread.join(PATIENCE)


def test_what_arrives_is_the_approved_plan(controller, at, plan, waypoints, approval, tmp_path):
    one = controller()
    receipts = list(send(plan, approval, at(one.port)))
    lines = [json.loads(line) for line in (tmp_path / "arrived.jsonl").read_text().splitlines()]
    assert [line["arm"] for line in lines] == [arm for arm, _ in waypoints]
    for line, (_, q) in zip(lines, waypoints, strict=True):
        assert np.abs(np.rad2deg(np.array(line["q"]) - q)).max() < 0.005
    assert [receipt.done for receipt in receipts] == list(range(1, len(receipts) + 1))
    assert receipts[-1].total == len(receipts)
    state = one.state()
    assert (state["placed"], state["fault"]) == (2, "")
    for arm in at(1).arms:
        np.testing.assert_allclose(state["joints"][arm.name], arm.home, atol=1e-4)


def test_two_watchers_see_the_parts_placed(controller, at, plan, approval):
    # Slow enough that a busy machine does not miss a whole arm between two reports.
    one = controller(speed=12.0)
    seen: list[list] = [[], []]
    over = threading.Event()

    def watch(into: list) -> None:
        into.extend(watch_state("127.0.0.1", one.state_port, over.is_set))

    threads = [threading.Thread(target=watch, args=(into,)) for into in seen]
    for thread in threads:
        thread.start()
    wait_until(lambda: all(seen))
    list(send(plan, approval, at(one.port)))
    wait_until(lambda: all(states[-1].placed == 2 for states in seen))
    over.set()
    for thread in threads:
        thread.join(PATIENCE)
    for states in seen:
        assert states[-1].placed == 2
        assert {"right", "left"} <= {state.moving for state in states}
        assert any(state.openings["right"] > 0 for state in states)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"plan_digest": "0" * 64}, "another plan"),
        ({"cell_digest": "0" * 64}, "another cell"),
        ({"scan_digest": "0" * 64}, "another scan"),
        ({"until": 1.0}, "ran out"),
        ({"at": time.time() + 3.6e9}, "begins in 3.* s: a clock has been set back"),
    ],
)
@pytest.mark.parametrize("protocol", ["abb-socket", "abb-socket/2"])
def test_nothing_is_sent_that_was_not_approved(
    controller, at, plan, approval, protocol, change, says
):
    one = controller()
    with pytest.raises(CommandRefused, match=says):
        next(send(plan, replace(approval, **change), at(one.port, protocol=protocol)))
    assert one.state()["received"] == 0


def test_an_approval_that_runs_out_while_waiting_sends_nothing(at, plan, approval):
    times = iter([approval.at, approval.at, approval.until + 1])

    def late(client, got):
        client.sendall(b"send")
        got.append(client.recv(256))

    with controller_that(late) as (port, got), pytest.raises(CommandRefused, match="ran out"):
        next(send(plan, approval, at(port), now=lambda: next(times)))
    assert got == [b""]


def test_a_plan_for_a_changed_cell_is_not_sent(controller, at, plan, approval):
    one = controller()
    changed = at(one.port)
    changed = replace(changed, policy=replace(changed.policy, margin=0.004))
    with pytest.raises(CommandRefused, match="cell"):
        next(send(plan, approval, changed))


def test_a_controller_that_is_not_there(at, plan, approval):
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with pytest.raises(LinkError, match=f"no controller answers at 127.0.0.1:{port}"):
        next(send(plan, approval, at(port)))


def test_a_host_that_cannot_be(cell, plan, approval):
    name = f"{'a' * 64}.example"
    elsewhere = replace(cell, controller=replace(cell.controller, host=name))
    with pytest.raises(LinkError, match=f"no controller answers at {name}"):
        next(send(plan, approval, elsewhere))
    with pytest.raises(LinkError, match=f"no controller reports its state at {name}"):
        next(watch_state(name, 1))


def test_a_controller_that_closes_in_the_middle(cell, at, plan, approval):
    def close_after_three(client, got):
        for _ in range(3):
            client.sendall(b"send")
            got.append(client.recv(256))

    receipts = []
    with (
        controller_that(close_after_three) as (port, got),
        pytest.raises(LinkError, match="message 4 of"),
    ):
        for receipt in send(plan, approval, at(port)):
            receipts.append(receipt)
    assert [data.decode() for data in got] == [m.text for m in messages(cell, plan)[:3]]
    assert [receipt.sent for receipt in receipts] == [data.decode() for data in got]


def test_garbage_instead_of_a_request(at, plan, approval):
    with (
        controller_that(lambda client, got: client.sendall(b"hello")) as (port, _),
        pytest.raises(ProtocolError, match="hello"),
    ):
        next(send(plan, approval, at(port)))


def test_a_request_said_twice_sends_nothing_more(at, plan, approval):
    def twice(client, got):
        client.sendall(b"send")
        got.append(client.recv(256))
        client.sendall(b"sendsend")
        got.append(client.recv(256))

    with controller_that(twice) as (port, got), pytest.raises(ProtocolError):
        list(send(plan, approval, at(port)))
    assert got == [got[0], b""]


def test_a_silent_controller(at, plan, approval):
    with (
        controller_that(lambda client, got: got.append(client.recv(256))) as (port, got),
        pytest.raises(LinkError, match="silent"),
    ):
        next(send(plan, approval, at(port), patience=replace(PATIENT, answer=0.2)))
    assert got == [b""]


def test_stop_ends_the_sending_and_the_controller_faults(controller, at, plan, approval):
    one = controller(speed=2.0)
    sent: list = []
    with pytest.raises(JobCancelled):
        for receipt in send(plan, approval, at(one.port), cancelled=lambda: len(sent) >= 3):
            sent.append(receipt)
    assert len(sent) == 3
    wait_until(lambda: one.state()["fault"])
    assert "left in the middle" in one.state()["fault"]
    assert one.state()["placed"] == 0


def test_after_a_fault_the_next_client_is_served(controller, at, plan, approval):
    one = controller()
    with socket.create_connection(("127.0.0.1", one.port)) as link:
        link.recv(4)
        link.sendall(b"nonsense###")
        assert link.recv(4) == b""
    receipts = list(send(plan, approval, at(one.port)))
    assert receipts[-1].done == receipts[-1].total
    assert one.state()["fault"] == ""


def test_a_second_client_is_turned_away(controller):
    one = controller()
    with socket.create_connection(("127.0.0.1", one.port)) as first:
        assert first.recv(4) == b"send"
        with socket.create_connection(("127.0.0.1", one.port)) as second:
            second.settimeout(PATIENCE)
            assert second.recv(4) == b""
        first.sendall(b"startR#")
        assert first.recv(4) == b"send"


def test_bytes_in_small_pieces_are_understood(controller, cell, plan):
    one = controller()
    with socket.create_connection(("127.0.0.1", one.port)) as link:
        link.settimeout(PATIENCE)
        link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for message in messages(cell, plan)[:4]:
            assert link.recv(4) == b"send"
            for byte in message.text.encode():
                link.sendall(bytes([byte]))
        assert link.recv(4) == b"send"
    assert one.state()["received"] == 4


STATE = (
    '{"joints": {"right": [%s]}, "openings": {}, "moving": "", '
    '"received": %s, "placed": 0, "fault": ""}'
)


@pytest.mark.parametrize(
    "line",
    [
        b"{}",
        b"[" * 60_000,
        (STATE % ("NaN", "1")).encode(),
        (STATE % ("1e999", "1")).encode(),
        (STATE % ("1" + 400 * "0", "1")).encode(),
        (STATE % ("0", "Infinity")).encode(),
        (STATE % ("0", str(2**31))).encode(),
        (STATE % ("0", "-1")).encode(),
        b"7",
        b"\xff",
    ],
    ids=[
        "empty",
        "deep",
        "nan",
        "infinite",
        "huge",
        "infinite count",
        "too many",
        "negative",
        "number",
        "no text",
    ],
)
def test_a_state_report_that_is_none(line):
    def nonsense(client, got):
        client.sendall(line + b"\n")

    with controller_that(nonsense) as (port, _), pytest.raises(ProtocolError, match="no state"):
        next(watch_state("127.0.0.1", port))


def test_a_fault_that_cannot_be_recorded_is_a_fault_all_the_same():
    def says(client, got):
        line = {"joints": {}, "openings": {}, "moving": "\ud800", "received": 0, "placed": 0}
        client.sendall(json.dumps({**line, "fault": "\ud800" + "x" * 5000}).encode() + b"\n")

    with controller_that(says) as (port, _):
        state = next(watch_state("127.0.0.1", port))
    assert state.moving == "?"
    assert state.fault.startswith("?xxx") and len(state.fault.encode()) == 300


def test_watchers_that_have_left_make_room_for_others(controller):
    """Also while nothing changes, and so nothing is told to anybody."""
    one = controller()
    for _ in range(MOST_WATCHERS + 5):
        with socket.create_connection(("127.0.0.1", one.state_port)) as watcher:
            watcher.settimeout(PATIENCE)
            assert watcher.recv(4096).endswith(b"\n")

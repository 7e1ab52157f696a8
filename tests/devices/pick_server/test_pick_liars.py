"""Robot programs that lie: none gets a leg that does not follow, and none keeps a sending."""

import socket
import time

import numpy as np
import pytest
from pick_scenes import Program, Sent, another, elsewhere
from waiting import wait_until

from workbench.devices.pick_server import server as pick_server
from workbench.devices.pick_server.lines import Form, line_bytes


def said(robot, *words):
    return lambda: robot.ask(*words)


def stands(robot, offset):
    return robot.axes.format(robot.q + offset)


AT_THE_START = {
    "a leg before the plan": lambda r: r.ask("leg", "1"),
    "a point before the plan": lambda r: r.ask("point", "1", "1"),
    "done before the plan": lambda r: r.ask("done", "1", *r.joints()),
    "placed before the plan": lambda r: r.ask("placed"),
    "next without joints": lambda r: r.ask("next"),
    "next with five joints": lambda r: r.ask("next", *r.joints()[:5]),
    "next with a word": lambda r: r.ask("next", *r.joints()[:5], "nan"),
    "next with infinity": lambda r: r.ask("next", *r.joints()[:5], "inf"),
    "next with an exponent": lambda r: r.ask("next", *r.joints()[:5], "1e3"),
    "next from elsewhere": lambda r: r.ask("next", *stands(r, 0.02)),
    "next beyond the limits": lambda r: r.ask("next", *["9999.00"] * 6),
    "state beyond the limits": lambda r: r.ask("state", *["9999.00"] * 6),
    "state with a text": lambda r: r.ask("state", "here"),
    "a desk that is not there": lambda r: r.ask("scan"),
}

WITH_THE_PLAN = {
    "the second leg first": lambda r: r.ask("leg", "2"),
    "leg 0": lambda r: r.ask("leg", "0"),
    "leg 9999": lambda r: r.ask("leg", "9999"),
    "next once more": lambda r: r.ask("next", *r.joints()),
    "done without a leg": lambda r: r.ask("done", "1", *r.joints()),
    "picked without a grip": lambda r: r.ask("picked"),
    "failed without a grip": lambda r: r.ask("failed", "empty"),
    "placed without a grip": lambda r: r.ask("placed"),
    "scan while it moves": lambda r: r.ask("scan"),
    "another recipe": lambda r: r.ask("recipe", "1"),
    "its own stop": lambda r: r.ask("stop", "guard"),
    "impossible joints": lambda r: r.ask("state", *["9999.00"] * 6),
}

IN_THE_FIRST_LEG = {
    "the leg again": lambda r: r.ask("leg", "1"),
    "the leg after it": lambda r: r.ask("leg", "2"),
    "a point twice": lambda r: r.ask("point", "1", "1"),
    "done elsewhere": lambda r: r.ask("done", "1", *stands(r, 0.02)),
    "done of another leg": lambda r: r.ask("done", "2", *r.joints()),
    "done where it began": lambda r: r.ask("done", "1", *r.axes.format(r.home)),
    "placed in the first leg": lambda r: r.ask("placed"),
    "next in the first leg": lambda r: r.ask("next", *r.joints()),
}


def lied(planned, until, lie, number):
    cell, plan, approval = planned
    # A plan that a program has taken ends by its silence; a busy machine may ask for it late.
    there = elsewhere(cell, silence_s=1.0, ask_s=60.0 if until else 2.0)
    sent = Sent(there, plan, another(approval, number))
    robot = Program(there, there.controller.port, run=number + 2)
    robot.home = np.asarray(cell.arms[0].home)
    try:
        if until > 0:
            robot.begin()
        if until > 1:
            robot.leg(1)
        answer = lie(robot)
        assert answer[0] not in ("PLAN", "LEG", "TO"), answer
        receipts, error = sent.ended()
    finally:
        robot.close()
    assert error is not None, "a lie brings no plan to its end"
    legs = [receipt for receipt in receipts if receipt.sent.startswith("LEG")]
    assert len(legs) == (until > 1), "nothing more has gone out"


LIES = [
    (until, name, lie)
    for until, lies in enumerate((AT_THE_START, WITH_THE_PLAN, IN_THE_FIRST_LEG))
    for name, lie in lies.items()
]


@pytest.mark.parametrize(
    ("number", "until", "lie"),
    [(k, until, lie) for k, (until, _, lie) in enumerate(LIES)],
    ids=[name for _, name, _ in LIES],
)
def test_a_lie_moves_nothing_and_leaves_no_sending(planned, number, until, lie):
    lied(planned, until, lie, number)


RAW = {
    "nothing at all": [],
    "no greeting": [line_bytes(Form(), "1", "next", *["0.00"] * 6)],
    "another version": [line_bytes(Form(), "0", "hello", "pick-server/9", "7")],
    "no end of the line": [b"0 hello " * 5000],
    "only bad checks": [b"1 next 0 0 0 0 0 0 00000\n"] * 200,
    "bytes that are no text": [bytes(range(128, 256)) + b"\n"] * 60,
}
assert len(LIES) + len(RAW) == 40


@pytest.mark.parametrize("name", RAW)
def test_whoever_does_not_speak_the_protocol_gets_no_plan_and_disturbs_nobody(planned, name):
    cell, plan, approval = planned
    there = elsewhere(cell)
    sent = Sent(there, plan, another(approval, 900 + len(name)))
    wait_until(lambda: bool(sent.shown), "the server")
    with socket.create_connection(("127.0.0.1", there.controller.port)) as liar:
        liar.settimeout(0.5)
        heard = b""
        try:
            for data in RAW[name]:
                liar.sendall(data)
            while piece := liar.recv(65536):
                heard += piece
        except (TimeoutError, ConnectionError):
            pass
        robot = Program(there, there.controller.port)
        robot.cycle()
        time.sleep(0.01)
    robot.close()
    assert sent.ended()[1] is None
    assert b"PLAN" not in heard and b"LEG" not in heard and b" TO " not in heard


def test_connections_that_drip_bytes_keep_no_place(planned, monkeypatch):
    cell, plan, approval = planned
    monkeypatch.setattr(pick_server, "GREETING", 0.5)
    there = elsewhere(cell)
    sent = Sent(there, plan, approval)
    wait_until(lambda: sent.shown)
    address = "127.0.0.1", there.controller.port
    dripping = [socket.create_connection(address) for _ in range(pick_server.MOST_CONNECTIONS)]

    def are_closed():
        for link in list(dripping):
            try:
                link.send(b"x")
            except OSError:
                link.close()
                dripping.remove(link)
        return not dripping

    wait_until(are_closed)
    robot = Program(there, there.controller.port)
    assert robot.begin() > 0
    assert robot.ask("stop", "over")[0] == "STOP"
    sent.ended()
    robot.close()

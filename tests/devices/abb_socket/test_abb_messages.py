"""The protocol as conversations, without sockets."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shipped import shipped

from workbench.devices.abb_socket.messages import (
    LONGEST_STRING,
    Commands,
    Requests,
    encode,
    messages,
)
from workbench.model.errors import InputError, ProtocolError

CELL = shipped("yumi")
RIGHT = CELL.arm("right")
LOWER, UPPER, _ = CELL.robot.limits(RIGHT.joints)


def hear_all(commands: Commands, text: str, cut: list[int] | None = None):
    """Feed a text in pieces; whatever comes out."""
    data = text.encode()
    ends = sorted({0, len(data), *(c % (len(data) + 1) for c in cut or [])})
    heard = [commands.hear(data[a:b]) for a, b in itertools.pairwise(ends)]
    assert heard[:-1] == [None] * (len(heard) - 1)
    return heard[-1]


def test_messages_are_those_of_the_protocol_byte_for_byte():
    q = np.deg2rad([1.0, -20.0, 77.77, 30.5, -0.001, 5.0, -135.0])
    assert encode(RIGHT, "start").text == "startR#"
    assert encode(RIGHT, "stop").text == "stopR#"
    assert encode(RIGHT, "in", q).text == "inR#*1.00*-20.00*30.50*0.00*5.00*-135.00*77.77*"
    assert encode(CELL.arm("left"), "out", q).text.startswith("outL#*1.00*-20.00*30.50*")


@settings(max_examples=100, deadline=None)
@given(
    shares=st.lists(st.floats(0, 1), min_size=7, max_size=7),
    cuts=st.lists(st.integers(0, 100), max_size=6),
)
def test_a_configuration_survives_the_wire_however_it_is_split(shares, cuts):
    q = LOWER + (UPPER - LOWER) * np.array(shares)
    message = encode(RIGHT, "in", q)
    assert len(message.text) <= LONGEST_STRING
    commands = Commands(CELL)
    assert hear_all(commands, "startR#").kind == "start"
    heard = hear_all(commands, message.text, cuts)
    assert (heard.arm, heard.kind) == ("right", "in")
    assert np.abs(heard.q - q).max() <= np.deg2rad(0.00501)


def test_every_waypoint_of_a_plan_is_sent_once_and_in_order(cell, plan, waypoints):
    sent = messages(cell, plan)
    commands = Commands(cell)
    heard = [hear_all(commands, message.text) for message in sent]
    assert commands.is_between
    arrived = [(message.arm, message.q) for message in heard if message.q is not None]
    assert [arm for arm, _ in arrived] == [arm for arm, _ in waypoints]
    for (_, q), (_, wanted) in zip(arrived, waypoints, strict=True):
        np.testing.assert_allclose(q, wanted, atol=1e-9)
    kinds = "".join(message.kind[0] for message in sent if message.arm == plan.arms[0].arm)
    assert kinds.strip("io") == kinds and kinds.count("s") == 4


NUMBERS = "*0.00*-90.00*30.00*0.00*40.00*0.00*0.00*"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["inR#" + NUMBERS], "was not started"),
        (["stopR#"], "was not started"),
        (["startR#", "startL#"], "before arm right stopped"),
        (["startR#", "outR#" + NUMBERS, "inR#" + NUMBERS], "after its way out"),
        (["startR#", "inL#" + NUMBERS], "was not started"),
        (["startX#"], "no message to one of the arms L, R"),
        (["goR#"], "no message"),
        (["startright"], "no message"),
        (["startR#stopR#"], "follows"),
        (["startR#", "inR#" + NUMBERS.replace("30.00", "30.0")], "two decimals"),
        (["startR#", "inR#" + NUMBERS.replace("30.00", "nan")], "two decimals"),
        (["startR#", "inR#" + NUMBERS.replace("30.00", "030.00")], "two decimals"),
        (["startR#", "inR#" + NUMBERS.replace("-90.00", "99.00")], "outside"),
        (["startR#", "inR#x" + NUMBERS], "between stars"),
        (["startR#", "inR#" + NUMBERS + NUMBERS], "longer than 80|between stars"),
        (["\xff"], "not text"),
        (["s" * 100], "longer than 80"),
    ],
)
def test_what_is_not_the_protocol_is_refused(words, says):
    commands = Commands(CELL)
    with pytest.raises(ProtocolError, match=says):
        for word in words:
            commands.hear(word.encode("latin-1"))


@settings(max_examples=200, deadline=None)
@given(st.lists(st.binary(min_size=1, max_size=30), max_size=8))
def test_garbage_ends_in_a_protocol_error_or_in_waiting(pieces):
    commands = Commands(CELL)
    try:
        for piece in pieces:
            commands.hear(piece)
    except ProtocolError:
        return
    assert len(commands._heard) <= LONGEST_STRING


def test_requests_come_in_any_pieces_but_one_at_a_time():
    requests = Requests()
    assert [requests.hear(piece) for piece in (b"s", b"en", b"d")] == [False, False, True]
    with pytest.raises(ProtocolError, match="sendsend"):
        requests.hear(b"sendsend")
    with pytest.raises(ProtocolError, match="hello"):
        Requests().hear(b"hello")


@pytest.mark.parametrize("bad", [None, np.zeros(3), np.full(7, np.nan)])
def test_a_configuration_that_is_none_cannot_be_encoded(bad):
    with pytest.raises(InputError):
        encode(RIGHT, "in", bad)

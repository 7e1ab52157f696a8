"""Who has to go from the door: values in, values out."""

import pytest
from aiohttp import web

from workbench.model.errors import FileError
from workbench.web.http.connection_limits import (
    GRACE_SECONDS,
    WAIT_SECONDS,
    WORK_SECONDS,
    ConnectionLimits,
    ConnectionRoom,
    room_for,
)
from workbench.web.http.origins import network_of


class Connection:
    """A connection, its socket, its protocol, and what it asks, in one."""

    def __init__(self, has_login=False, has_body=True):
        self.protocol = self.content = self
        self.has_login = has_login
        self.has_body = has_body
        self.unread = b""
        self.remote = "192.0.2.1"
        self.is_there = True

    @property
    def transport(self):
        return self if self.is_there else None

    def fileno(self):
        return 7 if self.is_there else -1

    def recv(self, size, flags):
        if not self.unread:
            raise BlockingIOError
        return self.unread[:size]

    def is_eof(self):
        return self.has_body

    def drop(self):
        self.is_there = False


def finished(coroutine):
    """What comes of a coroutine that waits for nothing; such may run inside one another."""
    try:
        coroutine.send(None)
    except StopIteration as end:
        return end.value
    raise AssertionError("it waits")


class Door:
    """Connection limits with a clock of its own."""

    def __init__(self, strangers=3, known=3):
        self.now = 0.0
        self.limits = ConnectionLimits(
            self.is_login, lambda: self.now, ConnectionRoom(strangers, known)
        )

    async def is_login(self, request):
        if request.has_login == "cannot tell":
            raise FileError("users.sqlite", "cannot be read")
        return request.has_login

    def come(self, *connections, address="192.0.2.1"):
        for one in connections:
            self.limits.enter(one, one, address, one.drop)
            self.now += 0.01
        return connections

    def ask(self, connection, until=None):
        """Ask something; what happens until it is answered."""

        async def answer(request):
            if until is not None:
                until()
            return "answer"

        return finished(self.limits.note(connection, answer))

    def after(self, seconds):
        self.now += seconds
        self.limits.close_overdue()


def these_are_there(connections):
    return [one.is_there for one in connections]


def test_without_a_login_a_connection_is_dropped_when_it_asks_nothing():
    door = Door()
    (silent,) = door.come(Connection())
    door.after(WAIT_SECONDS - 1)
    assert silent.is_there
    door.after(1)
    assert not silent.is_there


def test_who_has_asked_is_not_dropped_because_nobody_has_read_it():
    door = Door()
    asking, silent = door.come(Connection(), Connection())
    asking.unread = b"GET / HTTP/1.1"
    # So long nothing was done here: others had the processor.
    door.after(WAIT_SECONDS + 5)
    assert these_are_there([asking, silent]) == [True, False]
    asking.unread = b""
    door.after(1)
    assert not asking.is_there


def test_without_a_login_a_connection_is_dropped_when_it_asks_nothing_more():
    door = Door()
    one, known = door.come(Connection(), Connection(has_login=True))
    door.after(WAIT_SECONDS - 1)
    assert door.ask(one) == door.ask(known) == "answer"
    door.after(WAIT_SECONDS - 1)
    assert one.is_there
    door.after(1)
    assert not one.is_there
    assert known.is_there


def test_a_request_without_a_login_may_not_take_for_ever():
    door = Door()
    slow, known = door.come(Connection(), Connection(has_login=True))
    door.ask(known, until=lambda: door.after(WORK_SECONDS))
    assert known.is_there
    (slow,) = door.come(Connection())
    door.ask(slow, until=lambda: door.after(WORK_SECONDS - 1))
    assert slow.is_there
    door.ask(slow, until=lambda: door.after(WORK_SECONDS))
    assert not slow.is_there


def test_when_there_are_too_many_the_one_that_waits_longest_goes():
    door = Door()
    crowd = door.come(*(Connection() for _ in range(3)))
    door.now += 2 * GRACE_SECONDS
    door.ask(crowd[0])
    door.come(Connection())
    assert these_are_there(crowd) == [True, False, True]


def test_those_who_come_from_elsewhere_do_not_give_way_to_a_crowd():
    door = Door()
    (alone,) = door.come(Connection(), address="192.0.2.9")
    crowd = door.come(*(Connection() for _ in range(9)))
    assert alone.is_there
    assert sum(these_are_there(crowd)) == 2


def test_who_is_served_goes_last_unless_the_rest_of_the_request_is_waited_for():
    door = Door()
    served, trickling = door.come(Connection(), Connection(has_body=False))

    def crowd_comes():
        door.come(*(Connection() for _ in range(9)))
        assert these_are_there([served, trickling]) == [True, False]

    door.ask(served, until=lambda: door.ask(trickling, until=crowd_comes))


def test_whose_request_has_come_is_not_dropped_for_those_who_say_nothing():
    door = Door()
    read, unread = door.come(Connection(), Connection())
    door.limits.note_bytes(read)
    unread.unread = b"GET"
    door.come(*(Connection() for _ in range(9)))
    assert these_are_there([read, unread]) == [True, True]


def test_who_comes_is_not_dropped_for_those_who_ask_all_the_time():
    door = Door()
    (late,) = door.come(Connection())
    busy = door.come(Connection(), Connection())
    for one in busy:
        door.ask(one)
    door.come(Connection())
    assert these_are_there([late, *busy]) == [True, False, True]


def test_who_sends_a_request_bit_by_bit_has_no_claim_to_a_place():
    door = Door()
    (trickling,) = door.come(Connection())
    door.limits.note_bytes(trickling)
    door.now += 2 * GRACE_SECONDS
    door.limits.note_bytes(trickling)
    others = door.come(Connection(), Connection(), Connection())
    assert these_are_there([trickling, *others]) == [False, True, True, True]


def test_a_login_is_never_shut_out_by_those_without():
    door = Door()
    known = door.come(Connection(has_login=True))
    door.ask(*known)
    door.come(*(Connection() for _ in range(20)))
    door.limits.make_room(20)
    assert these_are_there(known) == [True]
    (another,) = door.come(Connection(has_login=True))
    door.come(Connection(), Connection())
    assert door.ask(another) == "answer"


def test_with_a_login_that_has_ended_a_connection_is_one_without():
    door = Door()
    (one,) = door.come(Connection(has_login=True))
    door.ask(one)
    one.has_login = False
    door.ask(one)
    door.after(WAIT_SECONDS)
    assert not one.is_there


@pytest.mark.parametrize("was_known", [True, False])
def test_when_nobody_can_tell_who_asks_all_stay_what_they_are(was_known):
    door = Door()
    (one,) = door.come(Connection(has_login=was_known))
    door.ask(one)
    one.has_login = "cannot tell"
    assert door.ask(one) == "answer"
    door.after(WAIT_SECONDS)
    assert one.is_there == was_known


def test_of_too_many_with_a_login_one_that_asks_nothing_goes():
    door = Door(strangers=9)
    known = door.come(*(Connection(has_login=True) for _ in range(4)))
    for one in known:
        door.ask(one)
    assert these_are_there(known) == [False, True, True, True]


def test_of_too_many_with_a_login_none_is_cut_off_while_it_is_served():
    door = Door(strangers=9, known=1)
    first, second = door.come(Connection(has_login=True), Connection(has_login=True))

    def second_asks():
        with pytest.raises(web.HTTPServiceUnavailable):
            door.ask(second)

    door.ask(first, until=second_asks)
    assert first.is_there


def test_who_goes_in_the_middle_of_a_request_is_no_error():
    door = Door()
    (one,) = door.come(Connection())

    def breaks():
        raise ConnectionResetError

    def goes():
        one.is_there = False
        breaks()

    with pytest.raises(ConnectionResetError):
        door.ask(one, until=breaks)
    with pytest.raises(web.HTTPBadRequest):
        door.ask(one, until=goes)


def test_who_has_gone_is_not_counted():
    door = Door()
    crowd = door.come(*(Connection() for _ in range(3)))
    crowd[2].is_there = False
    (late,) = door.come(Connection())
    assert these_are_there([*crowd, late]) == [True, True, False, True]


def test_room_is_made_of_those_without_a_login_the_longest_waiting_first():
    door = Door()
    crowd = door.come(*(Connection() for _ in range(3)))
    door.limits.make_room(2)
    assert these_are_there(crowd) == [False, False, True]


@pytest.mark.parametrize(
    ("address", "network"),
    [
        ("192.0.2.1", "192.0.2.1"),
        ("::ffff:192.0.2.1", "192.0.2.1"),
        ("2001:db8::1", "2001:db8::/64"),
        ("2001:db8::ffff:1", "2001:db8::/64"),
        ("2001:db8:0:1::1", "2001:db8:0:1::/64"),
        ("fe80::1%eth0", "fe80::/64"),
        ("", ""),
    ],
)
def test_an_address_is_counted_by_its_network(address, network):
    assert network_of(address) == network


@pytest.mark.parametrize("descriptors", [64, 256, 1024, 4096, 1 << 20])
def test_there_is_room_for_both_and_less_of_it_with_fewer_descriptors(descriptors):
    room = room_for(descriptors)
    assert room.strangers < room.known <= max(16, descriptors // 4)
    assert room.known <= room_for(2 * descriptors).known

"""The OPC UA server, spoken to by a client over loopback."""

import asyncio
import contextlib
import socket
import struct
from urllib.parse import urlsplit

import numpy as np
import pytest
from asyncua import Client, ua
from idle import Idle
from waiting import PATIENCE

from workbench.app.core.control import TakeControl
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import Person, Role
from workbench.app.runtime.bench import Bench
from workbench.extras.opcua import server as opcua_server
from workbench.extras.opcua.admission import Door, OpcUaOptions
from workbench.extras.opcua.server import MOST_CLIENTS, NAMESPACE, OpcUa
from workbench.extras.opcua.values import VARIABLES
from workbench.journal.journal import Journal
from workbench.model.errors import InputError
from workbench.web.access.lockout import MOST_FAILURES, WHILE

PLC = Person("plc", Role.OPERATOR)


@pytest.fixture
def serve(site):
    """Starts a server on a port that is free, and tells its address."""
    served = []

    def one(**options) -> str:
        served.append(OpcUa(site.bench, OpcUaOptions(0, PLC, **options)))
        return served[-1].url

    yield one
    for server in served:
        server.close()
        server.close()


@pytest.fixture(scope="module")
def shared(results, tmp_path_factory):
    """The address of a server for those who change nothing, or nothing for long."""
    bench = Bench(results.cell, Journal(tmp_path_factory.mktemp("shared")), effects=Idle)
    server = OpcUa(bench, OpcUaOptions(0, PLC))
    yield server.url
    server.close()
    bench.close()


def port_of(url) -> int:
    return urlsplit(url).port


class Hands:
    """A client's hands on the cell."""

    def __init__(self, client, cell, space):
        self._client, self._cell, self._space = client, cell, space

    async def read(self, name):
        return await (await self._cell.get_child(f"{self._space}:{name}")).read_value()

    async def call(self, name, *arguments):
        return await self._cell.call_method(f"{self._space}:{name}", *arguments)

    async def until(self, name, wanted):
        """Wait until a variable has a value."""
        for _ in range(int(PATIENCE / 0.05)):
            if await self.read(name) == wanted:
                return
            await asyncio.sleep(0.05)
        raise AssertionError(f"{name} is {await self.read(name)!r}, not {wanted!r}")


def talk(url, conversation):
    """Run a conversation with the cell."""

    async def run():
        async with Client(url, timeout=PATIENCE) as client:
            space = await client.get_namespace_index(NAMESPACE)
            cell = await client.nodes.objects.get_child(f"{space}:Workbench")
            await conversation(Hands(client, cell, space))

    asyncio.run(run())


def whole(value):
    return ua.Variant(value, ua.VariantType.UInt32)


def test_a_plc_runs_a_cycle_that_a_person_approves(site, serve):
    async def conversation(cell):
        assert await cell.read("Phase") == "idle"
        done, says = await cell.call("FindParts", whole(0))
        assert (done, says) == (
            False,
            "the search for parts is not possible now: take a scan first",
        )
        assert (await cell.call("Scan", whole(0), whole(2)))[0]
        await cell.until("Phase", "scanned")
        assert (await cell.call("FindParts", whole(0)))[0]
        await cell.until("PartsFound", 2)
        assert (await cell.call("MakePlan", whole(0), "auto", 0.2))[0]
        await cell.until("Phase", "planned")
        digest = await cell.read("PlanDigest")
        assert await cell.read("Holds") is True
        done, says = await cell.call("Send", digest)
        assert not done and "have the plan approved first" in says
        site.bench.do(WatchPlan(digest), "Ada")
        site.bench.do(Approve(digest), "Ada")
        await cell.until("ApprovedBy", "Ada")
        assert (await cell.call("Send", digest))[0]
        await cell.until("Phase", "done")
        assert await cell.read("PartsPlaced") == 2

    talk(serve(), conversation)


def test_a_plc_sends_what_a_person_approved_once_and_approves_nothing(site, serve):
    async def conversation(cell):
        for method in ("Approve", "WatchPlan", "Watch"):
            with pytest.raises(ua.UaError):
                await cell.call(method, "0" * 64)
        await cell.call("Scan", whole(0), whole(2))
        await cell.until("Phase", "scanned")
        await cell.call("FindParts", whole(0))
        await cell.until("PartsFound", 2)
        await cell.call("MakePlan", whole(0), "auto", 0.2)
        await cell.until("Phase", "planned")
        digest = await cell.read("PlanDigest")
        site.bench.do(WatchPlan(digest, is_reported=True), "Ada")
        site.bench.do(Approve(digest), "Ada")
        await cell.until("ApprovedBy", "Ada")
        done, says = await cell.call("Send", "0" * 64)
        assert not done and "look at the current one" in says
        site.stand(np.deg2rad(3.0))
        done, says = await cell.call("Send", digest)
        assert not done and "the robot has moved" in says
        assert site.effects.sent == []
        site.stand(0.0)
        assert (await cell.call("Send", digest))[0]
        await cell.until("Phase", "done")
        assert not (await cell.call("Send", digest))[0]
        assert site.effects.sent == [digest]

    talk(serve(), conversation)
    (word,), (out,) = map(site.on_record, ("Approve", "SendPlan"))
    assert (word["actor"], out["actor"]) == ("Ada", "plc")
    assert out["command"]["plan_digest"] == site.bench.state.plan.digest
    assert site.on_record("WatchPlan")[0]["command"]["is_told"] is True, "no page has shown it"


def test_every_variable_is_there_and_only_read(shared):
    async def conversation(cell):
        for name in VARIABLES:
            await cell.read(name)
        there = "auto, alternated, coordinated, right, left, both"
        assert await cell.read("Strategies") == there
        node = await cell._cell.get_child(f"{cell._space}:Phase")
        with pytest.raises(ua.UaError):
            await node.write_value("done")

    talk(shared, conversation)


def test_whoever_calls_acts_as_the_named_operator(site, serve):
    async def conversation(cell):
        assert (await cell.call("TakeControl"))[0]
        assert site.bench.state.control == "plc"
        await cell.until("Control", "plc")
        done, says = await cell.call("Scan", whole(0), whole(99))
        assert not done and "parts must be a whole number" in says
        done, says = await cell.call("Stop")
        assert not done and "nothing is being sent" in says

    talk(serve(), conversation)


def test_a_change_while_the_server_starts_is_told(site, serve, monkeypatch):
    subscribe = site.bench.subscribe

    def late(observer):
        site.bench.do(TakeControl(), "Ada")
        return subscribe(observer)

    monkeypatch.setattr(site.bench, "subscribe", late)

    async def conversation(cell):
        await cell.until("Control", "Ada")

    talk(serve(), conversation)


def test_a_password_is_asked_for(serve):
    url = serve(password="secret")

    async def come(name, password):
        client = Client(url, timeout=PATIENCE)
        if name:
            client.set_user(name)
            client.set_password(password)
        async with client:
            return True

    assert asyncio.run(come("plc", "secret"))
    for name, password in (("", ""), ("plc", "wrong"), ("admin", "secret")):
        with pytest.raises(ua.UaError):
            asyncio.run(come(name, password))


def test_passwords_are_not_tried_one_after_the_other(serve):
    url = serve(password="secret")

    async def come(password):
        client = Client(url, timeout=PATIENCE)
        client.set_user("plc")
        client.set_password(password)
        async with client:
            return True

    for number in range(MOST_FAILURES):
        with pytest.raises(ua.UaError):
            asyncio.run(come(f"guess {number}"))
    with pytest.raises(ua.UaError):
        asyncio.run(come("secret"))


def test_the_door_opens_again_after_a_while():
    clock = [0.0]
    door = Door(OpcUaOptions(0, PLC, password="secret"), now=lambda: clock[0])
    for _ in range(MOST_FAILURES):
        assert door.get_user(None, "plc", "guess") is None
    assert door.get_user(None, "plc", "secret") is None
    clock[0] = WHILE
    assert door.get_user(None, "plc", "secret") is not None


def test_methods_with_other_arguments_are_refused_by_a_status(shared):
    async def conversation(cell):
        for arguments, code in (
            ((), ua.StatusCodes.BadArgumentsMissing),
            ((whole(1),), ua.StatusCodes.BadArgumentsMissing),
            ((whole(1),) * 3, ua.StatusCodes.BadTooManyArguments),
        ):
            with pytest.raises(ua.UaStatusCodeError) as caught:
                await cell.call("Scan", *arguments)
            assert caught.value.code == code

    talk(shared, conversation)


def chunk(kind, final, body, announced=None):
    """A chunk as OPC UA's TCP carries it (Part 6, 7.1.2)."""
    return kind + final + struct.pack("<I", announced or 8 + len(body)) + body


HELLO = chunk(
    b"HEL", b"F", struct.pack("<5I", 0, 65535, 65535, 0, 0) + struct.pack("<i", 3) + b"opc"
)


@pytest.mark.parametrize(
    "flood",
    [
        chunk(b"MSG", b"C", b"x", announced=90_000_000),
        HELLO + chunk(b"OPN", b"F", b"x", announced=2**31 - 1),
        chunk(b"HEL", b"F", b"x", announced=2**32 - 1),
    ],
    ids=["no greeting", "open", "greeting"],
)
def test_what_a_header_announces_is_not_waited_for(shared, flood, caplog):
    with (
        socket.create_connection(("127.0.0.1", port_of(shared)), timeout=PATIENCE) as attacker,
        contextlib.suppress(ConnectionError),
    ):
        attacker.sendall(flood)
        for _ in range(64):
            attacker.sendall(bytes(65536))
        while attacker.recv(4096):
            pass
    assert "its message is too long" in caplog.text

    async def look(hands):
        assert await hands.read("Fault") == ""

    talk(shared, look)


def test_a_message_in_many_chunks_is_cut_off(shared):
    async def run():
        async with Client(shared, timeout=PATIENCE) as client:
            with pytest.raises((ua.UaError, ConnectionError, asyncio.CancelledError)):
                await client.nodes.objects.call_method("0:none", "x" * 2_000_000)

    with contextlib.suppress(ConnectionError):
        asyncio.run(run())

    async def look(hands):
        assert await hands.read("Fault") == ""

    talk(shared, look)


def test_nobody_else_gets_at_it_without_a_password(site):
    with pytest.raises(InputError, match="give a password"):
        OpcUa(site.bench, OpcUaOptions(0, PLC, host="0.0.0.0"))


def test_a_port_that_is_taken_is_said(site, shared):
    with pytest.raises(InputError, match="choose another port"):
        OpcUa(site.bench, OpcUaOptions(port_of(shared), PLC))


def test_a_server_that_is_closed_while_it_has_something_to_tell_ends(site):
    server = OpcUa(site.bench, OpcUaOptions(0, PLC))

    async def change_and_end():
        server._changed.set()
        # So that what is waited for and the end come at once.
        await asyncio.sleep(0)
        server._teller.cancel()
        await asyncio.wait([server._teller], timeout=PATIENCE)

    server._wait(change_and_end())
    assert server._teller.cancelled()
    server.close()


def test_a_crowd_is_not_taken_in(serve, monkeypatch):
    monkeypatch.setattr(opcua_server, "LOGIN_SECONDS", PATIENCE)
    url, crowd = serve(), []
    with contextlib.ExitStack() as opened:
        for _ in range(MOST_CLIENTS + 1):
            crowd.append(opened.enter_context(connected(url)))
        assert crowd[-1].recv(1) == b""
        crowd[0].setblocking(False)
        with pytest.raises(BlockingIOError):
            crowd[0].recv(1)


def test_who_does_not_log_in_is_not_kept_for_long(site, monkeypatch):
    monkeypatch.setattr(opcua_server, "LOGIN_SECONDS", 0.2)
    server = OpcUa(site.bench, OpcUaOptions(0, PLC))
    with contextlib.closing(server), contextlib.ExitStack() as opened:
        for one in [opened.enter_context(connected(server.url)) for _ in range(MOST_CLIENTS)]:
            assert one.recv(1) == b""
        # There is room again, for who has all the time that it takes.
        server._server.iserver.max_pending_activation_seconds = PATIENCE

        async def look(hands):
            assert await hands.read("Fault") == ""

        talk(server.url, look)


def connected(url):
    return socket.create_connection(("127.0.0.1", port_of(url)), timeout=3 * PATIENCE)

"""While our side hangs or fails, a PLC reads the state and stops the robot."""

import asyncio

from asyncua import Client
from hung_disk import HungDisk
from waiting import PATIENCE, wait_until

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import SendPlan, Sent
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import StopSending
from workbench.app.core.people import Person, Role
from workbench.extras.opcua import server as opcua_server
from workbench.extras.opcua.admission import OpcUaOptions
from workbench.extras.opcua.server import NAMESPACE, OpcUa
from workbench.model.release import Receipt


def begin_sending(site):
    """Bring the bench to a sending that goes on."""
    do = site.bench.do
    for command, phase in ((TakeScan(), "scanned"), (FindParts(), "localized")):
        do(command, "Ada")
        site.reach(phase)
    do(MakePlan(), "Ada")
    site.reach("planned")
    digest = site.bench.state.plan.digest
    do(WatchPlan(digest, is_reported=True), "Ada")
    do(Approve(digest), "Ada")
    site.effects.hold.set()
    return do(SendPlan(digest), "Ada")


def test_a_plc_reads_and_stops_while_the_disk_hangs(site, monkeypatch):
    number, stops = begin_sending(site).number, []
    run = site.effects.run

    def noted(effect):
        stops.extend([effect] if isinstance(effect, StopSending) else ())
        run(effect)

    monkeypatch.setattr(site.effects, "run", noted)
    server = OpcUa(site.bench, OpcUaOptions(0, Person("plc", Role.OPERATOR)))
    disk = HungDisk(site.bench._journal, monkeypatch)
    receipt = Sent(Receipt(number, "right", "start", "startR#", 1, 4))

    async def stop():
        async with Client(server.url, timeout=PATIENCE) as client:
            space = await client.get_namespace_index(NAMESPACE)
            cell = await client.nodes.objects.get_child(f"{space}:Workbench")
            phase = await cell.get_child(f"{space}:Phase")
            assert await phase.read_value() == "sending"
            answer = asyncio.create_task(cell.call_method(f"{space}:Stop"))
            await asyncio.to_thread(wait_until, lambda: stops)
            disk.free()
            is_done, says = await answer
            assert is_done, says

    try:
        with disk.during(site.bench.do, receipt, "robot link"):
            asyncio.run(stop())
    finally:
        server.close()


def test_a_state_that_cannot_be_told_once_is_told_the_next_time(site, monkeypatch):
    server = OpcUa(site.bench, OpcUaOptions(0, Person("plc", Role.OPERATOR)))
    tell, failures = opcua_server.values_of, []

    def fail_once(*words):
        if not failures:
            failures.append(words)
            raise ValueError("a value of another type")
        return tell(*words)

    monkeypatch.setattr(opcua_server, "values_of", fail_once)

    async def watch():
        async with Client(server.url, timeout=PATIENCE) as client:
            space = await client.get_namespace_index(NAMESPACE)
            cell = await client.nodes.objects.get_child(f"{space}:Workbench")
            phase = await cell.get_child(f"{space}:Phase")
            site.bench.do(TakeScan(), "Ada")
            await asyncio.to_thread(site.reach, "scanned")
            await asyncio.to_thread(wait_until, lambda: failures)
            async with asyncio.timeout(PATIENCE):
                while await phase.read_value() != "scanned":
                    await asyncio.sleep(0.02)

    try:
        asyncio.run(watch())
    finally:
        server.close()

"""No key lets a robot move: all that have one are pressed where it could."""

import asyncio
import contextlib

import msgspec
import pytest
from raw_browser import raw_browser
from waiting import wait_until

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import NextStep, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import WORKER
from workbench.app.core.state import Phase
from workbench.gui.page.server import serve
from workbench.studies.load.raw_browser import unpack

ANNA = {"X-WB-Key": "secret", "X-WB-User": "Anna", "X-WB-Role": "engineer"}
LAST = "New scan"
"""Pressed after all others, and on record once it was taken."""


@pytest.fixture
def planned(bench, scan, detections, result):
    """Somebody has watched the plan to its end: a press of a button would approve it."""
    for command, brought in (
        (TakeScan(0, 2), scan),
        (FindParts(0), detections),
        (MakePlan(threshold=bench.cell.policy.threshold), result),
    ):
        bench.do(command, "Anna")
        bench.do(JobEnded(bench.state.job.number, brought), WORKER)
    bench.do(WatchPlan(bench.state.plan.digest), "Anna")
    return bench


@pytest.fixture
def asked(planned, monkeypatch):
    commands, do = [], planned.do
    monkeypatch.setattr(
        planned, "do", lambda command, *who: commands.append(type(command)) or do(command, *who)
    )
    return commands


async def press_all(port, asked):
    """Press every key that the page has; what they are for."""
    keys = {}
    async with raw_browser(port, ANNA) as browser:
        while LAST not in keys or len(keys) < 12:
            for message in unpack(await browser.recv()):
                if message["type"] == "RegisterCommandMessage":
                    keys[message["props"]["label"]] = message["uuid"]
        with contextlib.suppress(TimeoutError):
            while True:
                for message in unpack(await asyncio.wait_for(browser.recv(), 1.0)):
                    if message["type"] == "RegisterCommandMessage":
                        keys[message["props"]["label"]] = message["uuid"]
        for label in sorted(keys, key=lambda label: label == LAST):
            pressed = {"type": "CommandTriggerMessage", "uuid": keys[label]}
            await browser.send(msgspec.msgpack.encode(pressed))
        await asyncio.to_thread(wait_until, lambda: TakeScan in asked, "the last key")
    return keys


@pytest.mark.parametrize("is_approved", [False, True])
def test_no_key_approves_sends_or_runs_a_step(planned, asked, is_approved):
    if is_approved:
        planned.do(Approve(planned.state.plan.digest), "Anna")
        asked.clear()
    page = serve(planned, port=0, secret="secret")
    try:
        keys = asyncio.run(press_all(int(page.url.rpartition(":")[2]), asked))
    finally:
        page.close()
    assert {"Plan", "Find parts", "Play or pause the plan"} <= set(keys)
    assert not {Approve, SendPlan, NextStep, WatchPlan} & set(asked)
    assert planned.state.phase is not Phase.SENDING

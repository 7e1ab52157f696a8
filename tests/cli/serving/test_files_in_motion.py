"""Large CAD files chosen on a served page while the robot moves: it comes to its end, and stops."""

import asyncio
import re

import pytest
from waiting import PATIENCE

from workbench.cli.measuring.page.page_process import PROCESS_NAME, serve_page
from workbench.studies.stalls.actions import choose_file, has_ended, let_out, open_page, plan_two
from workbench.studies.stalls.large_files import CAD, cad_file
from workbench.studies.stalls.visit import visit

PASSWORD = "only for this test"

STALLS = "stalls.jsonl"

TRIES = 3
"""A machine that gives a process no processor for two seconds ends a motion as well."""


@pytest.fixture(scope="module")
def files():
    return {kind: cad_file(kind) for kind in CAD}


@pytest.fixture
def page(tmp_path):
    with serve_page(tmp_path, "yumi", PASSWORD, "--stalls", STALLS) as page:
        yield page
    # Whatever a busy machine makes of times: no line that reads meshes has run in that process.
    stalls = (tmp_path / STALLS).read_text().splitlines()
    readers = [line for line in stalls if "look_at" in line or "formats/meshes/repair" in line]
    assert readers == []


def at(page, use):
    """Use a page, with an end to all patience."""

    async def bounded():
        async with (
            asyncio.timeout(TRIES * PATIENCE),
            visit(page.url, PROCESS_NAME, PASSWORD, page.token) as one,
        ):
            await open_page(one)
            return await use(one)

    return asyncio.run(bounded())


def test_a_motion_comes_to_its_end_whatever_is_read_meanwhile(page, files):
    async def ends_well(one, name, content):
        await plan_two(one)
        await choose_file(one, name, content)
        await let_out(one)
        state = await one.until(has_ended, "the end")
        await one.wait_for_text(name, "closed")
        if state["phase"] == "done":
            assert state["parts_placed"] == 2
            return ""
        await one.post("/acknowledge")
        return state["fault"]

    async def use(one):
        for kind, content in files.items():
            faults = []
            while fault := await ends_well(one, f"ring-{len(faults)}{kind}", content):
                faults.append(fault)
                assert len(faults) < TRIES, faults

    at(page, use)


def test_a_stop_waits_for_no_file(page, files):
    async def use(one):
        await plan_two(one)
        await choose_file(one, "ring.stl", files[".stl"])
        await let_out(one)
        await one.post("/stop")
        texts = list(one.browser.texts.values())
        return texts, await one.until(has_ended, "the end")

    texts, ended = at(page, use)
    assert any(re.search(r"ring\.stl.*reading", text) for text in texts), "it was read before"
    assert ended["phase"] == "fault"
    assert "stopped" in ended["fault"]

"""What people and programs do with a page, one after the other."""

import asyncio
import zipfile
from collections.abc import AsyncGenerator, Awaitable, Callable
from contextlib import aclosing
from dataclasses import dataclass
from io import BytesIO
from typing import Any

from workbench.model.cell import Cell
from workbench.model.errors import LinkError
from workbench.studies.load.raw_browser import RawBrowser
from workbench.studies.stalls.large_files import CAD, cad_file, cloud
from workbench.studies.stalls.visit import Visit

Doing = Callable[[Visit], Awaitable[None]]

READS = (
    "/state", "/jobs/current", "/scan", "/detections", "/candidates", "/plan", "/proof",
    "/proof/certificate", "/emptying", "/statistics", "/sessions",
)  # fmt: skip

SMALL = 2_000
"""Triangles of a part that is made, not only checked: that takes a worker minutes otherwise."""

POSES = 30
"""In a file; more are not taken."""

SETTLES = 3.0
"""[s] After a doing, for what it leaves to be drawn and counted."""


@dataclass(frozen=True, slots=True)
class Files:
    """Made beforehand: what makes them must not look like a slow page."""

    cad: dict[str, bytes]
    small: bytes
    scan: bytes


def files_for(cell: Cell, triangles: int, points: int) -> Files:
    """The files that are sent."""
    cad = {kind: cad_file(kind, triangles) for kind in CAD}
    return Files(cad, cad_file(".stl", SMALL), cloud(cell, points))


def doings(files: Files) -> dict[str, Doing]:
    """What is done, by names for people, in this order."""

    def looked_at(button: str, kind: str, content: bytes) -> Doing:
        async def does(visitor: Visit) -> None:
            name = f"{button.split()[-1]}-ring{kind}"
            await visitor.choose(button, name, content, "closed")

        return does

    cads = {
        f"a CAD file is chosen ({kind[1:].upper()}, {len(content) / 1e6:.0f} MB)": looked_at(
            "Choose a CAD file", kind, content
        )
        for kind, content in files.cad.items()
    }
    return {
        "the page is opened": open_page,
        "another one in German": _in_german,
        "a cycle to the plan": plan_two,
        "all answers are read": _read,
        "the plan is sent": _send,
        "the same four times, with a CAD file read meanwhile": lambda visitor: _sent_beside(
            visitor, files.cad
        ),
        "a scan is sent": lambda visitor: _scan(visitor, files.scan),
        "its points are read": _points,
        "parts are looked for in it": _search,
        "poses are sent": _poses,
        **cads,
        "the same as a tool's body": looked_at("Choose the body", ".stl", files.cad[".stl"]),
        "piles are emptied": _empty,
        "a part is made": lambda visitor: _make(
            visitor, "Choose a CAD file", "Make the part", files.small
        ),
        "a tool is made": lambda visitor: _make(
            visitor, "Choose the body", "Add the tool", files.small
        ),
        "the cell is saved": _save,
        "the session is taken along": lambda visitor: _download(visitor, "/session.zip"),
        "a backup is taken along": lambda visitor: _download(visitor, "/backup.zip"),
        "a backup is restored": _restore,
    }


async def open_page(visitor: Visit) -> None:
    """Wait for the controls and be in control."""
    await visitor.until(lambda state: "Choose a backup" in visitor.browser.widgets, "the controls")
    await visitor.wait_for_task()
    if not (await visitor.state())["control"]:
        await visitor.post("/control/take")


async def _in_german(visitor: Visit) -> None:
    browser = RawBrowser(visitor.browser.url, visitor.browser.session)
    async with aclosing(_frames(browser)) as frames:
        async for _ in frames:
            if "Scannen" in browser.widgets or len(browser.widgets) > 100:
                return


async def _frames(browser: RawBrowser) -> AsyncGenerator[Any]:
    await browser.open(**{"Accept-Language": "de"})
    try:
        while (frame := await browser.read()) is not None:
            yield frame
    finally:
        if browser.socket is not None:
            await browser.socket.close()


async def plan_two(visitor: Visit) -> None:
    """Scan two parts, find them and plan."""
    for path, body in (("/scan", {"parts": 2}), ("/localize", {}), ("/plan", {})):
        await visitor.post(path, **body)
        await visitor.wait_for_task()


async def _read(visitor: Visit) -> None:
    for path in READS:
        await visitor.get(path)
    await _points(visitor)


async def _points(visitor: Visit) -> None:
    await visitor.get("/scan/points")


async def _send(visitor: Visit) -> None:
    await let_out(visitor)
    await visitor.until(has_ended, "the end of a motion")


async def let_out(visitor: Visit) -> None:
    """Approve the plan and send it."""
    plan = (await visitor.state())["plan"]
    for path in ("/watch", "/approve", "/send"):
        await visitor.post(path, plan=plan)


def has_ended(state: dict[str, Any]) -> bool:
    """Whether the motion is over."""
    return state["phase"] in ("done", "fault")


async def _sent_beside(visitor: Visit, cad: dict[str, bytes]) -> None:
    for kind, content in cad.items():
        await plan_two(visitor)
        # Once something is sent no file can be chosen any more; one that was is still read.
        await choose_file(visitor, f"beside{kind}", content)
        await let_out(visitor)
        state = await visitor.until(has_ended, "the end of a motion")
        if state["phase"] != "done":
            raise LinkError(f"the motion was broken off: {state['fault']}")
        await visitor.wait_for_text(f"beside{kind}", "closed")


async def choose_file(visitor: Visit, name: str, content: bytes) -> None:
    """Choose a CAD file, until the page says that it is being read."""
    await visitor.choose("Choose a CAD file", name, content, "reading …")


async def _scan(visitor: Visit, content: bytes) -> None:
    before = (await visitor.state())["scan"]
    await visitor.browser.upload("Scan from file", "scan.ply", content)
    await visitor.until(lambda state: state["scan"] not in (None, before), "the scan")


async def _search(visitor: Visit) -> None:
    await visitor.post("/localize")
    await visitor.wait_for_task()


async def _poses(visitor: Visit) -> None:
    row = ["1", "0", "0", "400", "0", "1", "0", "0", "0", "0", "1", "20"]
    numbers = row * POSES
    content = "\n".join([str(len(numbers)), *(f"2 {number}" for number in numbers)]).encode()
    await visitor.browser.upload("Poses from file", "poses.tup", content)
    await visitor.until(lambda state: state["detections"] == POSES, "the poses")


async def _make(visitor: Visit, choose: str, make: str, content: bytes) -> None:
    name = f"{make.split()[-1]}_small"
    before = (await visitor.state())["cell_digest"]
    await visitor.choose(choose, f"{name}.stl", content, "closed")
    await visitor.browser.set(make, True)

    def is_over(state: dict[str, Any]) -> bool:
        return state["cell_digest"] != before or "failed" in state["message"]

    state = await visitor.until(is_over, "another cell")
    if state["cell_digest"] == before:
        raise LinkError(state["message"])


async def _save(visitor: Visit) -> None:
    await visitor.post("/cell/save")
    await visitor.until(lambda state: state["is_saved"], "the files")


async def _empty(visitor: Visit) -> None:
    await visitor.post("/emptying", parts=4, piles=1)
    await visitor.wait_for_task()


async def _download(visitor: Visit, path: str) -> None:
    await visitor.get(path, raw=True)


async def _restore(visitor: Visit) -> None:
    file = BytesIO(await visitor.get("/backup.zip", raw=True))
    with zipfile.ZipFile(file, "a") as kept:
        kept.writestr("parts/added/note.txt", "another one")
    content = file.getvalue()
    await visitor.choose("Choose a backup", "kept.zip", content, "added")
    await asyncio.sleep(0.5)
    await visitor.browser.set("Restore it", True)
    await visitor.wait_for_text("kept.zip is restored")

"""What pictures of the page are made with: a cell of its own, a browser, small files."""

import io
import json
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

from chromium import find_chromium
from conftest import FLAGS, PATIENCE, Screen
from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from workbench.app.core.state import State
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.formats.cells.reading import cell_path, part_folders, read_cell
from workbench.gui.page.server import serve
from workbench.journal.journal import Journal
from workbench.model.cell import Cell

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
FONT = ROOT / "static" / "inter.woff2"
TYPEFACE = "@font-face{font-family:Inter;font-weight:100 900;src:url(/static/inter.woff2)}"
SIZE = {"width": 1280, "height": 800}
MOST_POINTS = 60_000
LARGEST = 250_000
"""[bytes] No still picture is larger."""


class Desk:
    """A bench, its page, and a browser window on it.

    Lifetime: inside of `desk`.
    """

    def __init__(self, bench: Bench, screen: Screen):
        """Made by `desk`."""
        self.bench, self.screen, self.page = bench, screen, screen.page

    def reach(self, phase: str) -> State:
        """Wait for a phase of the cycle with no task under way."""
        state = self.bench.wait(lambda now: now.phase == phase and now.job is None, PATIENCE)
        if state.phase != phase:
            raise RuntimeError(f"stuck in {state.phase}: {state.message}")
        return state

    def wait(self, condition: Callable[[], bool], what: str) -> None:
        """Wait for what must happen."""
        until = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > until:
                raise RuntimeError(f"waited {PATIENCE:.0f} s in vain for {what}")
            time.sleep(0.02)

    def shoot(self, name: str, *, is_moving: bool = False) -> None:
        """Keep what is on the screen as `docs/pictures/NAME.webp`, once it stands still."""
        save(seen(self.page) if is_moving else settled(self.page), name)


@contextmanager
def browser() -> Iterator[Browser]:
    """Headless Chromium, WebGL drawn by the processor."""
    chromium = find_chromium()
    if chromium is None:
        raise SystemExit("no chromium here; on Debian: apt-get install chromium-headless-shell")
    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        yield made
        made.close()


@contextmanager
def desk(
    chrome: Browser, folder: Path, speed: float, changed: Callable[[Cell], Cell] = lambda cell: cell
) -> Iterator[Desk]:
    """The page of the simulated YuMi cell, which may be changed and saved, and its controller.

    Args:
        chrome: from `browser`.
        folder: the working directory; cells and parts are copied into it.
        speed: of the simulated robot, 1 is real time.
        changed: makes another cell of the one that is shipped.
    """
    with cell_bench(folder, speed, changed) as bench:
        page = serve(
            bench, port=0, most_points=MOST_POINTS, folders=part_folders(cell_path("yumi"))
        )
        try:
            with window(chrome, page.url) as screen:
                yield Desk(bench, screen)
        finally:
            page.close()


@contextmanager
def cell_bench(
    folder: Path, speed: float, changed: Callable[[Cell], Cell] = lambda cell: cell
) -> Iterator[Bench]:
    """The bench of a `desk`, without a page, and its controller."""
    for kind in ("robots", "parts", "static"):
        shutil.copytree(ROOT / kind, folder / kind, dirs_exist_ok=True)
    cell = changed(read_cell("yumi"))
    arguments = ["--port", "0", "--state-port", "0", "--speed", str(speed), "--until-eof", "--json"]
    with subprocess.Popen(
        [sys.executable, "-m", "workbench", "controller", *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as robot:
        assert robot.stdin is not None and robot.stdout is not None
        ports = json.loads(robot.stdout.readline())
        at = {"port": ports["port"], "state_port": ports["state_port"]}
        controller = replace(cell.controller, **at, is_simulated=True)
        bench = Bench(
            replace(cell, controller=controller),
            Journal(folder / f"session-{time.time_ns()}"),
            effects=partial(EffectRunner, cell_file=cell_path("yumi")),
        )
        try:
            yield bench
        finally:
            bench.close()
            robot.stdin.close()


@contextmanager
def window(chrome: Browser, url: str) -> Iterator[Screen]:
    """A browser window on a page, ready to be used, without viser's warning about slow drawing."""
    context = chrome.new_context(viewport=SIZE)
    context.route("**/static/inter.woff2", lambda route: route.fulfill(path=FONT))
    screen = Screen(context.new_page(), PICTURES)
    screen.page.goto(url)
    screen.page.locator(".wb-strip").first.wait_for(timeout=PATIENCE * 1000)
    # For people the front, which stands before the page, serves the typeface.
    screen.page.add_style_tag(content=TYPEFACE)
    close_notes(screen)
    yield screen
    context.close()


def close_notes(screen: Screen) -> None:
    """Take away the notes that cover the page, as soon as there is one."""
    note = screen.page.locator(".mantine-Notification-closeButton")
    try:
        note.first.wait_for(timeout=5000)
    except Exception:
        return
    while note.count():
        screen.page.evaluate(
            "document.querySelectorAll('.mantine-Notification-closeButton').forEach(b => b.click())"
        )
        screen.page.wait_for_timeout(400)


def settled(page: Page) -> Image.Image:
    """What is on the screen once two looks at it show the same."""
    page.wait_for_timeout(1200)
    before = b""
    for _ in range(12):
        now = page.screenshot(timeout=PATIENCE * 1000)
        if now == before:
            break
        before = now
        page.wait_for_timeout(500)
    return picture_of(now)


def seen(page: Page) -> Image.Image:
    """What is on the screen now."""
    return picture_of(page.screenshot(timeout=PATIENCE * 1000))


def picture_of(content: bytes) -> Image.Image:
    """A picture from the content of a file."""
    return Image.open(io.BytesIO(content)).convert("RGB")


def save(image: Image.Image, name: str) -> None:
    """Write a picture so that letters stay sharp and the file small."""
    path = PICTURES / f"{name}.webp"
    for quality in (92, 85, 75):
        image.save(path, quality=quality, method=6)
        if path.stat().st_size < LARGEST:
            break
    tell(path)


def tell(path: Path) -> None:
    """Say what was written."""
    print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1000:.0f} kB", flush=True)


def save_moving(images: list[Image.Image], name: str, width: int, seconds: float) -> None:
    """Write pictures that follow each other `seconds` apart, over and over, as one WebP file."""
    small = [
        image.resize((width, round(image.height * width / image.width)), Image.Resampling.LANCZOS)
        for image in images
    ]
    path = PICTURES / f"{name}.webp"
    durations = [round(seconds * 1000)] * len(small)
    durations[-1] += 1500
    small[0].save(
        path,
        save_all=True,
        append_images=small[1:],
        duration=durations,
        loop=0,
        quality=72,
        method=6,
    )
    tell(path)

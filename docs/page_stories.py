"""The stories that the pictures tell, each by hands on the real page."""

import re
from pathlib import Path

from hands import field
from picture_tools import Desk, desk, save_moving, seen
from playwright.sync_api import Browser

PERSON = "Ada"
SEED = 28
"""Of a pile whose two parts go to both arms."""

FRAMES = 40
"""Of the picture that moves."""


def cycle(chrome: Browser, folder: Path) -> None:
    """From an empty page to parts on their trays."""
    with desk(chrome, folder, speed=0.2) as at:
        screen, page = at.screen, at.page
        at.shoot("start")
        page.get_by_label("Seed").fill(str(SEED))
        page.wait_for_timeout(300)
        screen.press("Scan")
        at.reach("scanned")
        at.shoot("scanned")
        screen.press("Find parts")
        at.reach("localized")
        screen.tab("Parts")
        page.locator(".wb-parts:visible tbody tr").first.click()
        at.shoot("parts")
        screen.tab("Cycle")
        plan(at)
        at.shoot("planned")
        refused(at)
        keys(at)
        screen.tab("Plan")
        play(at)
        watch(at)
        screen.tab("Cycle")
        approve(at)
        screen.press("Send")
        screen.tab("Robot")
        at.wait(lambda: at.bench.live.link.step > 1, "the second step")
        at.shoot("robot", is_moving=True)
        at.reach("done")
        screen.tab("Cycle")
        field(screen, "Why it failed").press_sequentially("slipped", delay=100)
        screen.press("Left failed")
        at.wait(lambda: {o.is_picked for o in at.bench.state.outcomes} == {True, False}, "words")
        at.shoot("done")


def plan(at: Desk) -> None:
    """Press Plan and wait for the plan."""
    at.screen.press("Plan")
    at.reach("planned")
    at.screen.wait_for("plan ready")


def refused(at: Desk) -> None:
    """A candidate that cannot be taken, with where it fails."""
    at.screen.tab("Candidates")
    filters = at.page.locator(".wb-filter:visible", has_text=re.compile("collision|blocked"))
    filters.first.click()
    at.page.wait_for_timeout(800)
    at.page.locator(".wb-table:visible tbody tr").first.click()
    at.page.wait_for_timeout(4000)
    at.shoot("candidates")
    at.screen.press("Hide in scene")


def keys(at: Desk) -> None:
    """The list of keys."""
    at.screen.tab("Cycle")
    at.page.mouse.move(200, 400)
    at.page.keyboard.press("Control+k")
    at.page.wait_for_timeout(800)
    at.shoot("keys")
    at.page.keyboard.press("Escape")
    at.page.wait_for_timeout(500)


def play(at: Desk) -> None:
    """The plan, stopped again and again, as one moving picture and one still."""
    at.page.wait_for_timeout(500)
    seconds = at.bench.state.plan.cycle_seconds
    images = []
    for number in range(FRAMES):
        show_time(at, seconds * number / (FRAMES - 1))
        images.append(seen(at.page))
    save_moving(images, "play", 640, 0.25)
    show_time(at, 0.42 * seconds)
    at.shoot("plan")


def show_time(at: Desk, seconds: float) -> None:
    """Put both arms where they are at that time of the plan."""
    box = field(at.screen, "Time [s]")
    box.fill(f"{seconds:.2f}")
    box.press("Enter")
    at.page.wait_for_timeout(900)


def watch(at: Desk) -> None:
    """Play the plan to its end, as the rules want it before an approval."""
    at.screen.press("To the start")
    at.screen.press("Play")
    at.wait(lambda: bool(at.bench.state.watched), "the end of the plan")


def approve(at: Desk, name: str = "approval") -> None:
    """Approve as a person, and keep a picture of the dialog."""
    at.screen.press("Approve")
    dialog = at.page.get_by_role("dialog")
    dialog.locator("input").first.press_sequentially(PERSON, delay=100)
    at.screen.button(f"Approve as {PERSON}").wait_for()
    if name:
        at.shoot(name)
    at.screen.press(f"Approve as {PERSON}")
    at.reach("approved")


def fault(chrome: Browser, folder: Path) -> None:
    """A robot that was stopped while it moved."""
    with desk(chrome, folder, speed=0.2) as at:
        screen = at.screen
        screen.press("Scan")
        at.reach("scanned")
        screen.press("Find parts")
        at.reach("localized")
        plan(at)
        at.page.mouse.move(200, 400)
        at.page.keyboard.press("k")
        at.wait(lambda: bool(at.bench.state.watched), "the end of the plan")
        approve(at, "")
        screen.press("Send")
        at.wait(lambda: at.bench.live.link.step > 0, "the robot to move")
        screen.press("Stop")
        at.reach("fault")
        screen.wait_for("Fault:")
        at.page.mouse.move(400, 780)
        at.shoot("fault")

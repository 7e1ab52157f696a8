"""A picture of each point of the list that the page was mended by: `make pictures ARGS=points`.

The page is seen as people come to it: behind the front, with the bar above the scene.  What is
written to `build/points/` is looked at and not kept; the documents have pictures of their own.
"""

import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from conftest import Screen
from front_page import open_front
from hands import field
from picture_tools import PATIENCE, PICTURES, ROOT, Desk, cell_bench, close_notes, settled
from playwright.sync_api import Browser, Page, Route

from workbench.app.core.state import State
from workbench.app.review.history import History
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.web.server import Front

POINTS = ROOT / "build" / "points"
SIZE = {"width": 1280, "height": 720}
"""The smallest page that the list asks for."""

PERSON = "Ada"
SLOW, QUICK = 0.1, 20.0
"""Speeds of the simulated robot: one that can be watched, one that is soon done."""

WIDE = 60.0
"""[mm] A margin that no way out of the bin keeps."""

HALF = 0.42
"""[of the plan's time] Parts are in the hands."""


class Fronted(Desk):
    """A desk whose screen is the scene within the page of the front."""

    def __init__(self, bench: Bench, outer: Page, link: str):
        """Made by `serve_with_front`."""
        frame = outer.locator("#scene").element_handle().content_frame()
        super().__init__(bench, Screen(frame, PICTURES))
        self.outer, self.link = outer, link

    def point(self, number: int, of: str) -> None:
        """Keep what is on the screen as the picture of a point."""
        keep(self.outer, number, of)

    def key(self, name: str) -> None:
        """Press a key over the scene."""
        self.outer.mouse.move(500, 500)
        self.screen.page.locator("body").press(name)

    def to_plan(self, seed: int = 28) -> State:
        """Scan, find the parts and plan."""
        set_number(self, "Seed", seed)
        for button, phase in (
            ("Scan", "scanned"),
            ("Find parts", "localized"),
            ("Plan", "planned"),
        ):
            self.screen.press(button)
            state = self.reach(phase)
        self.screen.wait_for("plan ready")
        return state

    def approve(self) -> None:
        """Open the approval of a plan that was watched, and sign as a person."""
        self.screen.tab("Cycle")
        self.screen.press("Approve")
        dialog = self.screen.page.get_by_role("dialog")
        dialog.locator("input").first.press_sequentially(PERSON, delay=100)
        self.screen.button(f"Approve as {PERSON}").wait_for()


@contextmanager
def fronted(chrome: Browser, folder: Path, speed: float) -> Iterator[Fronted]:
    """The page behind its front, and the robot's controller."""
    with cell_bench(folder, speed) as bench, front_of(bench, folder) as front:
        context = chrome.new_context(viewport=SIZE)
        context.set_default_timeout(60_000)
        page = context.new_page()
        page.goto(front.link)
        at = Fronted(bench, page, front.link)
        at.screen.page.locator(".wb-strip").first.wait_for()
        close_notes(at.screen)
        with suppress(Exception):
            page.get_by_role("button", name="Not now").click(timeout=5000)
        yield at
        context.close()


@contextmanager
def front_of(bench: Bench | History, folder: Path) -> Iterator[Front]:
    """A front that is closed again."""
    front, *ends = open_front(bench, folder / "users.sqlite")
    try:
        yield front
    finally:
        for end in ends:
            end.close()


def keep(page: Page, number: int, of: str) -> None:
    """Write a picture of a point, once it stands still."""
    POINTS.mkdir(parents=True, exist_ok=True)
    settled(page).save(POINTS / f"{number:02}-{of}.png")
    print(f"point {number}: {of}", flush=True)


def set_number(at: Fronted, label: str, value: object) -> None:
    """Type into the input beside a label."""
    box = field(at.screen, label)
    box.fill(str(value))
    box.press("Tab")
    at.screen.page.wait_for_timeout(400)


def first_load(page: Page, link: str) -> None:
    """The page while what it is made of has not come yet."""

    def hold(route: Route) -> None:
        """Answer later: whoever ends the holding lets all of them go on."""

    page.route("**/scene/**", hold)
    page.goto(link, wait_until="commit")
    page.locator("#wait").wait_for()
    keep(page, 13, "loading")
    page.context.close()


def before_the_plan(at: Fronted) -> None:
    """Tour, languages, views, keys, the search that compares, and the cell's numbers."""
    screen, page = at.screen, at.screen.page
    at.outer.get_by_role("button", name="Tour").click()
    with suppress(Exception):
        at.outer.get_by_role("button", name="Begin").click(timeout=2000)
    at.point(21, "tour")
    at.outer.get_by_role("button", name=re.compile("Leave|Not now|Close")).click()
    set_number(at, "Seed", 28)
    screen.press("Scan")
    at.reach("scanned")
    screen.press("Find parts")
    at.reach("localized")
    at.key("2")
    at.point(12, "views")
    at.key("1")
    screen.tab("Parts")
    page.get_by_text("Search again in this scan", exact=True).click()
    page.wait_for_timeout(500)
    screen.press("Search again")
    screen.button("Take this one").wait_for()
    at.wait(lambda: at.bench.state.job is None, "the search")
    at.outer.mouse.move(500, 500)
    page.wait_for_timeout(3000)
    at.point(14, "search-again")
    page.get_by_text("Search again in this scan", exact=True).click()
    page.locator(".wb-parts:visible").first.evaluate("one => one.scrollIntoView({block: 'center'})")
    at.outer.mouse.move(500, 500)
    at.point(16, "words")
    screen.tab("Cell")
    at.point(15, "numbers")
    screen.tab("Grasps")
    screen.press("Edit grasps")
    page.wait_for_timeout(2500)
    page.get_by_text("Copies and patterns", exact=True).click()
    page.wait_for_timeout(500)
    page.get_by_text("Around [deg]").first.evaluate("one => one.scrollIntoView({block: 'center'})")
    at.point(19, "copies")
    screen.press("Back to cell")
    at.key("l")
    screen.tab("Cycle")
    at.key("Control+k")
    at.point(22, "keyboard")
    at.key("Escape")
    at.key("l")


def with_the_plan(at: Fronted) -> None:
    """Candidates, the plan's tab, the preview, and every strategy at once."""
    screen, page = at.screen, at.screen.page
    screen.press("Plan")
    plan = at.reach("planned").plan
    screen.wait_for("plan ready")
    screen.tab("Candidates")
    page.locator(".wb-filter:visible", has_text=re.compile("collision|blocked")).first.click()
    page.wait_for_timeout(800)
    page.locator(".wb-table:visible tbody tr").first.click()
    page.wait_for_timeout(4000)
    at.point(11, "candidates")
    screen.press("Hide in scene")
    screen.tab("Plan")
    at.point(5, "clearances")
    at.point(20, "legs-of-both-arms")
    for number, of, share in ((1, "preview", 0.2), (4, "in-the-hands", HALF)):
        set_number(at, "Time [s]", f"{share * plan.cycle_seconds:.2f}")
        page.wait_for_timeout(900)
        at.point(number, of)
    screen.press("To the start")
    screen.press("Play")
    at.wait(lambda: bool(at.bench.state.watched), "the end of the plan")
    at.point(3, "end")
    screen.press("To the start")
    at.key("l")
    page.get_by_text("Least clearance").first.evaluate("one => one.scrollIntoView()")
    at.point(9, "plots-in-the-dark")
    at.key("l")


def sending(at: Fronted) -> None:
    """Step by step, on its way, stopped."""
    screen, page = at.screen, at.screen.page
    at.approve()
    page.get_by_role("dialog").locator("input[type=checkbox]").check()
    screen.press(f"Approve as {PERSON}, step by step")
    at.reach("approved")
    screen.press("Send")
    at.wait(lambda: at.bench.state.waits == 1, "the robot to wait")
    at.point(18, "step-by-step")
    page.get_by_role("button", name=re.compile("^Run step 1")).click()
    at.wait(lambda: at.bench.live.link.step > 0, "the robot to move")
    screen.tab("Robot")
    at.point(8, "stop-on-every-tab")
    at.outer.locator("#stop").click()
    at.reach("fault")
    screen.tab("Cycle")
    at.point(2, "after-a-stop")
    screen.tab("Statistics")
    page.get_by_text("Session as one file").scroll_into_view_if_needed()
    at.point(20, "taken-along")


def refused(at: Fronted) -> None:
    """A margin that is not kept; both strategies; another language."""
    screen, page = at.screen, at.screen.page
    strategy = field(screen, "Strategy")
    strategy.click()
    page.get_by_role("option", name="both", exact=True).click()
    at.to_plan()
    screen.tab("Plan")
    at.point(10, "both")
    screen.tab("Cycle")
    page.get_by_text("How it is planned", exact=True).click()
    page.wait_for_timeout(500)
    set_number(at, "Margin [mm]", WIDE)
    screen.press("Plan")
    at.wait(lambda: at.bench.state.job is None and at.bench.state.plan is None, "no plan")
    at.point(7, "margin")
    at.outer.locator("#language select").select_option("de")
    at.outer.wait_for_timeout(2000)
    at.outer.locator("#wait").wait_for(state="hidden")
    at.outer.frame_locator("#scene").locator(".wb-strip").first.wait_for()
    at.point(17, "german")


def points(chrome: Browser, folder: Path) -> None:
    """Every point of the list, each with a picture."""
    for name, speed, told in (
        ("pick", SLOW, (before_the_plan, with_the_plan, sending)),
        ("no_plan", QUICK, (refused,)),
    ):
        (folder / name).mkdir()
        with fronted(chrome, folder / name, speed) as at:
            for tell in told:
                tell(at)
    recorded(chrome, folder)
    loading(chrome, folder)


def loading(chrome: Browser, folder: Path) -> None:
    """The first load, of a front of its own."""
    (folder / "loading").mkdir()
    own = folder / "loading"
    with cell_bench(own, QUICK) as bench, front_of(bench, own) as front:
        first_load(chrome.new_context(viewport=SIZE).new_page(), front.link)


def recorded(chrome: Browser, folder: Path) -> None:
    """A recorded session, framed as one."""
    journal = Journal(shutil.copytree(ROOT / "sessions" / "example", folder / "example"))
    try:
        with front_of(History(journal), folder) as front:
            page = chrome.new_context(viewport=SIZE).new_page()
            page.goto(front.link)
            page.frame_locator("#scene").locator(".wb-mode").first.wait_for(timeout=PATIENCE * 1000)
            close_notes(Screen(page.locator("#scene").element_handle().content_frame(), PICTURES))
            keep(page, 6, "recorded")
            page.context.close()
    finally:
        journal.close()

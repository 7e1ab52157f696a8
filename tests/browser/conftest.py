"""A real browser, a bench with its worker, and a controller in a process of its own."""

import functools
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest
from chromium import find_chromium
from forking import fork_workers
from front_page import open_front
from hands import pause
from own_cell import own, own_bench, own_url  # noqa: F401
from patient import PATIENT
from playwright.sync_api import Browser, BrowserContext, Locator, Page, expect, sync_playwright
from waiting import PATIENCE, wait_until

from workbench.app.core.state import State
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.formats.cells.reading import read_cell
from workbench.gui.page.server import Page as ServedPage
from workbench.gui.page.server import serve
from workbench.journal.journal import Journal
from workbench.model.cell import Controller

ROOT = Path(__file__).resolve().parents[2]

IMPORTED_FROM = (ROOT, ROOT / "tests", ROOT / "tests" / "devices")
"""By processes beside this one."""

# Otherwise what is expected has to be so within five seconds.
expect.set_options(timeout=PATIENCE * 1000)

FLAGS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-dev-shm-usage",
    # Text and boxes drawn by WebGL's stand-in take twice the time.
    "--disable-gpu-rasterization",
    # So does putting a page together: while a task is under way it is done for each bit of it.
    "--disable-gpu-compositing",
    # A busy machine draws slowly: that is no reason to end what draws.
    "--disable-gpu-watchdog",
]
"""WebGL drawn by the processor."""

LOOKED_AT = os.environ.get("WORKBENCH_SCREENSHOTS")
"""Where pictures are kept for people, if they are."""

WINDOW = {
    "viewport": {"width": 1280, "height": 720},
    "reduced_motion": "reduce",
}
"""Every window, as it opens."""

FEWER_PICTURES = """
(() => {
  const next = window.requestAnimationFrame.bind(window);
  let last = 0, waiting = new Map(), timer = null, filled = -Infinity, isFilled = true;
  const draw = (now) => {
    const due = waiting;
    waiting = new Map();
    timer = null;
    isFilled = now >= filled + EMPTY_FOR;
    if (isFilled) filled = now;
    for (const one of due.values()) one(now);
  };
  window.requestAnimationFrame = (one) => {
    waiting.set(++last, one);
    timer ??= setTimeout(() => next(draw), 100);
    return last;
  };
  window.cancelAnimationFrame = (number) => waiting.delete(number);
  const canvas = WebGL2RenderingContext.prototype;
  for (const name of Object.getOwnPropertyNames(canvas)) {
    if (!/^(clear|draw(Arrays|Elements|Range)|blit)/.test(name)) continue;
    if (/^clear(Color|Depth|Stencil)$/.test(name)) continue;
    const fill = canvas[name];
    canvas[name] = function (...what) { if (isFilled) return fill.apply(this, what); };
  }
})();
"""
"""Ten pictures a second at most: what a browser draws in vain the other tests lack, and Chromium
draws with a higher priority than they have.  Of most pictures everything is computed but what
WebGL fills with colour, which takes a processor 50 to 100 ms each."""

EMPTY_FOR = 10_000
"""[ms] From one picture that is filled to the next, where no test asks for the colours of any."""


@dataclass
class Robot:
    """A simulated controller in its own process."""

    process: subprocess.Popen[str]
    port: int
    state_port: int
    record: Path

    def controller(self, usual: Controller) -> Controller:
        """Where a cell finds it."""
        return replace(usual, port=self.port, state_port=self.state_port, is_simulated=True)

    @property
    def configurations(self) -> list[dict]:
        """What has arrived so far."""
        if not self.record.exists():
            return []
        return [json.loads(line) for line in self.record.read_text().splitlines()]


@dataclass
class Screen:
    """One open browser window and the hands on it."""

    page: Page
    shots: Path
    errors: list[str] = field(default_factory=list)

    def button(self, name: str) -> Locator:
        return self.page.get_by_role("button", name=name, exact=True)

    def press(self, name: str) -> None:
        """Press a button, as soon as it can be pressed."""
        # viser passes on one message each 50 ms: people are slower than that, programs are not.
        pause(self.page, 80)
        self.button(name).click(timeout=PATIENCE * 1000)

    def tab(self, name: str) -> None:
        self.page.get_by_role("tab", name=name).click()

    def text(self, selector: str) -> str:
        return self.page.locator(selector).first.inner_text()

    def wait_for(self, text: str) -> None:
        # The same words may stand in a tab that is not shown.
        shown = self.page.get_by_text(text).locator("visible=true").first
        shown.wait_for(timeout=PATIENCE * 1000)

    def shoot(self, name: str) -> None:
        """Keep a picture for people to look at."""
        self.page.screenshot(path=self.shots / f"{name}.png", timeout=PATIENCE * 1000)


@pytest.fixture(scope="session")
def shots(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where pictures go: a temporary folder, or the one named in the environment."""
    folder = Path(LOOKED_AT) if LOOKED_AT else tmp_path_factory.mktemp("screenshots")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


# As long as it lives, an event loop runs in this thread: tests of other files have their own.
@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    chromium = find_chromium()
    if chromium is None:
        pytest.skip("no chromium here; on Debian: apt-get install chromium-headless-shell")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def speed() -> float:
    """Of the simulated robot; 1 is real time."""
    return 20.0


@pytest.fixture
def robot(tmp_path: Path, speed: float) -> Iterator[Robot]:
    record = tmp_path / "arrived.jsonl"
    process = subprocess.Popen(
        [sys.executable, Path(__file__).with_name("patient_robot.py"), str(speed), str(record)],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(map(str, IMPORTED_FROM))},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    yield Robot(process, *json.loads(process.stdout.readline()), record)
    process.stdin.close()
    process.wait(timeout=PATIENCE)
    process.stdout.close()


@pytest.fixture(autouse=True)
def forked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers of a page start as they do for people in tests of the runtime."""
    fork_workers(monkeypatch)


@pytest.fixture
def bench(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Bench]:
    """With a robot for the tests that ask for one; the others need none."""
    cell = read_cell("yumi")
    # A real robot's first plans would be offered at a quarter of their speed.
    cell = replace(cell, controller=replace(cell.controller, is_simulated=True))
    if "robot" in request.fixturenames:
        robot = request.getfixturevalue("robot")
        cell = replace(cell, controller=robot.controller(cell.controller))
    # Only what really never comes is missed: others compute here as well.
    effects = functools.partial(EffectRunner, patience=PATIENT)
    bench = Bench(cell, Journal(tmp_path / "session"), effects=effects)
    yield bench
    bench.close()


@pytest.fixture
def served(bench: Bench) -> Iterator[ServedPage]:
    page = serve(bench, port=0, most_points=4000)
    yield page
    page.close()


@pytest.fixture
def url(served: ServedPage) -> str:
    return served.url


@pytest.fixture
def are_filled() -> bool:
    """Whether all pictures are filled with colour: for tests that look at colours, and people."""
    return LOOKED_AT is not None


@pytest.fixture
def sharpness() -> float:
    """Pixels that are drawn for one of the page: fewer take less of a processor that draws them."""
    return 1.0 if LOOKED_AT else 0.5


@pytest.fixture
def new_context(
    browser: Browser, are_filled: bool, sharpness: float
) -> Iterator[Callable[..., BrowserContext]]:
    """Makes windows of their own, patient and without haste."""
    contexts: list[BrowserContext] = []

    def make(**wishes: str) -> BrowserContext:
        context = browser.new_context(**WINDOW, **wishes, device_scale_factor=sharpness)
        empty_for = 0 if are_filled else EMPTY_FOR
        context.add_init_script(f"const EMPTY_FOR = {empty_for};{FEWER_PICTURES}")
        context.set_default_timeout(PATIENCE * 1000)
        contexts.append(context)
        return context

    yield make
    for context in contexts:
        context.close()


@pytest.fixture
def open_screen(
    new_context: Callable[[], BrowserContext], url: str, shots: Path
) -> Callable[[], Screen]:
    """Opens the page in a new window, ready to be used."""

    def open_one() -> Screen:
        screen = Screen(new_context().new_page(), shots)
        screen.page.on(
            "console",
            lambda message: message.type == "error" and screen.errors.append(message.text),
        )
        screen.page.on("pageerror", lambda error: screen.errors.append(str(error)))
        screen.page.goto(url)
        screen.page.locator(".wb-strip").wait_for(timeout=PATIENCE * 1000)
        # viser warns about slow drawing; the warning covers what is to be pressed.
        # It may go by itself meanwhile, so it is not waited for.
        close = "document.querySelector('.mantine-Notification-closeButton')?.click()"
        screen.page.evaluate(close)
        return screen

    return open_one


@pytest.fixture
def screen(open_screen: Callable[[], Screen]) -> Screen:
    return open_screen()


@pytest.fixture
def wait() -> Callable[[Callable[[], bool], str], None]:
    return wait_until


@pytest.fixture
def reaches(bench: Bench) -> Callable[..., State]:
    """Waits for a phase of the cycle with no task under way."""

    def reach(phase: str) -> State:
        state = bench.wait(lambda state: state.phase == phase and state.job is None, PATIENCE)
        assert state.phase == phase, f"stuck in {state.phase}: {state.message}"
        return state

    return reach


@pytest.fixture
def front(bench, tmp_path):
    """The page behind its front, as people come to it."""
    front, *ends = open_front(bench, tmp_path / "users.sqlite")
    yield front
    for end in ends:
        end.close()

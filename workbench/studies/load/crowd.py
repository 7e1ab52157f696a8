"""The page under load: many browsers that read everything, one of which scrubs and types."""

import asyncio
import time
from contextlib import AsyncExitStack
from dataclasses import dataclass

import aiohttp

from workbench.model.errors import LinkError
from workbench.studies.load.raw_browser import RawBrowser, raw_browser

SCRUB = 1 / 30
"""Between two positions of the plan's time slider [s]."""

PRESS = 1.0
"""Between two values typed that become commands [s]."""

BUTTONS_TO_A_PLAN = ("Scan", "Find parts", "Plan")
"""Buttons that lead to a plan."""

TIME, THRESHOLD = "Time [s]", "Threshold [mm]"
"""The slider that is scrubbed; the field whose value becomes a command."""

SCRUBBED = 5.0
"""Part of the plan that is gone through to and fro [s]."""

THRESHOLDS = (190, 210)
"""Typed in turn, so that each is another than before [mm]."""

PREPARE_SECONDS = 180.0


@dataclass(frozen=True, slots=True)
class Load:
    """What a load was.

    Attributes:
        seconds: that it took.
        frames: that each browser read.
        size: bytes that each browser read.
        pressed: when each value was typed [s since 1970].
    """

    seconds: float
    frames: tuple[int, ...]
    size: tuple[int, ...]
    pressed: tuple[float, ...]


async def load(url: str, name: str, password: str, browsers: int, seconds: float) -> Load:
    """Lead the page to a plan, then load it.

    Args:
        url: of the front.
        name: of a user who may plan.
        password: of that user.
        browsers: how many, the one that scrubs included.
        seconds: how long.

    Raises:
        LinkError: the page does not answer, nobody could log in, or a browser was cut off.
    """
    try:
        return await _load(url, name, password, browsers, seconds)
    except (aiohttp.ClientError, ConnectionError) as error:
        raise LinkError(f"{url}: {error}") from error


async def _load(url: str, name: str, password: str, browsers: int, seconds: float) -> Load:
    async with AsyncExitStack() as stack:
        first = await enter(stack, url, name, password)
        try:
            async with asyncio.timeout(PREPARE_SECONDS):
                await make_plan(first)
        except (TimeoutError, ConnectionError) as error:
            raise LinkError(f"{url}: the page did not come to a plan: {error}") from error
        others = [await enter(stack, url, name, password) for _ in range(browsers - 1)]
        everybody = [first, *others]
        before = [(browser.frames, browser.bytes) for browser in everybody]
        began = time.monotonic()
        reading = [asyncio.create_task(browser.close_code()) for browser in everybody]
        pressed = await _use(everybody[0], began + seconds)
        if any(task.done() for task in reading):
            raise LinkError(f"{url}: a browser was cut off")
        for task in reading:
            task.cancel()
        await asyncio.gather(*reading, return_exceptions=True)
        after = zip(everybody, before, strict=True)
        counts = [
            (visitor.frames - frames, visitor.bytes - size) for visitor, (frames, size) in after
        ]
        took = time.monotonic() - began
    return Load(took, tuple(n for n, _ in counts), tuple(n for _, n in counts), tuple(pressed))


async def enter(stack: AsyncExitStack, url: str, name: str, password: str) -> RawBrowser:
    """One more browser at the page."""
    browser = await stack.enter_async_context(raw_browser(url))
    if await browser.log_in(name, password) != 303:
        raise LinkError(f"{url}: {name!r} cannot log in")
    await browser.open()
    return browser


async def make_plan(browser: RawBrowser) -> None:
    """Press one button after the other, as soon as it can be pressed."""
    # Widgets are made before they are told that they cannot be used yet.
    for label in (*BUTTONS_TO_A_PLAN[1:], TIME):
        await browser.find_enabled(label, is_enabled=False)
    if "Take control" in browser.widgets:
        await browser.set("Take control", True)
    for label in BUTTONS_TO_A_PLAN:
        await browser.find_enabled(label)
        await browser.set(label, True)
    await browser.find_enabled(TIME)


async def _use(browser: RawBrowser, until: float) -> list[float]:
    """Scrub to and fro, type now and then; when each was typed."""
    pressed: list[float] = []
    began = time.monotonic()
    while (now := time.monotonic()) < until:
        phase = (now - began) % (2 * SCRUBBED)
        await browser.set(TIME, round(min(phase, 2 * SCRUBBED - phase), 2))
        if now - began >= PRESS * (len(pressed) + 1) and until - now >= PRESS:
            pressed.append(time.time())
            await browser.set(THRESHOLD, THRESHOLDS[len(pressed) % len(THRESHOLDS)])
        await asyncio.sleep(max(0.0, SCRUB - (time.monotonic() - now)))
    return pressed

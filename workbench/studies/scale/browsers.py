"""Many browsers at one page: what one more costs, and how long a change takes to reach all."""

import asyncio
import os
import time
from collections.abc import Callable, Sequence
from contextlib import AsyncExitStack
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

from workbench.model.errors import LinkError
from workbench.studies.load.crowd import THRESHOLD, enter, make_plan
from workbench.studies.load.raw_browser import RawBrowser
from workbench.studies.scale.growth import Costs

COMMANDS = 7
"""Values that are typed one after the other."""

FIRST_VALUE = 181
"""[mm] The first that is typed, and each is one more: none is what the page begins with."""

REST = 1.0
"""[s] The page is at rest when no browser has read anything meanwhile."""

LONGEST = 60.0
"""[s] After which a page that does not come to rest is given up."""

KILOBYTE = 1000.0
MS = 1000.0


@dataclass(slots=True)
class Watch:
    """What browsers read: when the last frame came [s], and which of them have seen a value."""

    last: float = field(default_factory=time.monotonic)
    wanted: float | None = None
    seen: dict[int, float] = field(default_factory=dict[int, float])


@dataclass(frozen=True, slots=True)
class PageProcess:
    """The process that serves a page; `memory` gives its resident memory [MB]."""

    url: str
    number: int
    memory: Callable[[], float]

    @property
    def processor_seconds(self) -> float:
        """Its processor time up to now [s], as proc_pid_stat(5) has it."""
        fields = Path(f"/proc/{self.number}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


async def measure_browsers(page: PageProcess, name: str, password: str, count: int) -> Costs:
    """What `count` browsers cost together that come to a page which shows a plan.

    Args:
        page: the process that serves it.
        name: of a user who may plan.
        password: of that user.
        count: of browsers; one of them has made the plan and gives the commands.

    Raises:
        LinkError: nobody can log in, or the page does not come to rest.
    """
    async with AsyncExitStack() as stack:
        first = await enter(stack, page.url, name, password)
        async with asyncio.timeout(LONGEST):
            await make_plan(first)
        memory, before = page.memory(), page.processor_seconds
        # One more than count: with one browser, too, somebody comes.
        others = [await enter(stack, page.url, name, password) for _ in range(count)]
        watch, browsers = Watch(), [first, *others]
        reading = [asyncio.create_task(_read(browser, watch)) for browser in browsers]
        await _rest(watch)
        costs = {
            "all come, processor s": page.processor_seconds - before,
            "all come, MB of memory": page.memory() - memory,
            "one comes, kB": median(browser.bytes for browser in others) / KILOBYTE,
            **await _type(page, browsers, watch),
            **await _scan(page, browsers, watch),
        }
        for task in reading:
            task.cancel()
        await asyncio.gather(*reading, return_exceptions=True)
    return costs


async def measure_arrival(page: PageProcess, name: str, password: str) -> Costs:
    """What a browser costs that comes to a page, after another one has come.

    Raises:
        LinkError: nobody can log in, or the page does not come to rest.
    """
    costs: list[Costs] = []
    for _ in range(2):
        async with AsyncExitStack() as stack:
            before = page.processor_seconds
            browser = await enter(stack, page.url, name, password)
            watch = Watch()
            reading = asyncio.create_task(_read(browser, watch))
            await _rest(watch)
            costs.append(
                {
                    "a browser comes, processor s": page.processor_seconds - before,
                    "a browser comes, kB": browser.bytes / KILOBYTE,
                }
            )
            reading.cancel()
            await asyncio.gather(reading, return_exceptions=True)
    return costs[-1]


async def _type(page: PageProcess, browsers: Sequence[RawBrowser], watch: Watch) -> Costs:
    """Type values; until the last of the other browsers has seen each."""
    delays: list[float] = []
    before, size = page.processor_seconds, [browser.bytes for browser in browsers]
    for value in range(FIRST_VALUE, FIRST_VALUE + COMMANDS):
        watch.wanted, watch.seen = float(value), {}
        began = time.monotonic()
        await browsers[0].set(THRESHOLD, value)
        await _until(lambda: len(watch.seen) >= len(browsers) - 1)
        delays.append(max(watch.seen.values()) - began)
        await _rest(watch)
    read = [browser.bytes - old for browser, old in zip(browsers, size, strict=True)]
    return {
        "a command until all have seen it, ms": MS * median(delays),
        "a command, processor ms": MS * (page.processor_seconds - before) / COMMANDS,
        "a command, kB for one browser": median(read) / COMMANDS / KILOBYTE,
    }


async def _scan(page: PageProcess, browsers: Sequence[RawBrowser], watch: Watch) -> Costs:
    """Take one scan; until the last browser has read the last of it."""
    before, size = page.processor_seconds, [browser.bytes for browser in browsers]
    began = time.monotonic()
    await browsers[0].set("Scan", True)
    await _until(lambda: watch.last > began)
    await _rest(watch)
    read = [browser.bytes - old for browser, old in zip(browsers, size, strict=True)]
    return {
        "a scan until all have it, ms": MS * (watch.last - began),
        "a scan, processor ms": MS * (page.processor_seconds - before),
        "a scan, kB for one browser": median(read) / KILOBYTE,
    }


async def _read(browser: RawBrowser, watch: Watch) -> None:
    while (messages := await browser.read()) is not None:
        watch.last = time.monotonic()
        for message in messages:
            value = (message.get("updates") or {}).get("value")
            if isinstance(value, int | float) and value == watch.wanted:
                watch.seen.setdefault(id(browser), watch.last)


async def _rest(watch: Watch) -> None:
    await _until(lambda: time.monotonic() - watch.last > REST)


async def _until(condition: Callable[[], bool]) -> None:
    try:
        async with asyncio.timeout(LONGEST):
            while not condition():
                await asyncio.sleep(0.005)
    except TimeoutError as error:
        raise LinkError("the page did not answer all browsers in time") from error

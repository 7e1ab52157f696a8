"""The watchdog tells what keeps the interpreter or an event loop to itself, and by which line."""

import asyncio
import json
import threading
import time

import pytest
from waiting import wait_until

from workbench.model.errors import FileError
from workbench.studies.stalls.watchdog import Watchdog, stack_of, watch_stalls


@pytest.fixture
def stalls():
    return []


@pytest.fixture
def dog(stalls):
    dog = Watchdog(stalls.append)
    yield dog
    dog.close()


def keeps_the_interpreter():
    """One call into C for a good part of a second of processor time."""
    until = time.thread_time() + 0.3
    while time.thread_time() < until:
        sum(range(20_000_000))


def lets_others_run():
    until = time.thread_time() + 0.3
    while time.thread_time() < until:
        sum(number * number for number in range(100))


def in_a_thread(work):
    thread = threading.Thread(target=work, name=f"test {work.__name__}")
    thread.start()
    thread.join()


def test_who_keeps_the_interpreter_is_told_with_the_line(dog, stalls):
    wait_until(lambda: in_a_thread(keeps_the_interpreter) or stalls)
    stall = stalls[0]
    assert stall.kind == "interpreter"
    assert stall.thread == "test keeps_the_interpreter"
    assert any("keeps_the_interpreter" in frame for frame in stall.where)
    assert 0.05 <= stall.seconds <= stall.lasted


def test_who_lets_others_run_is_not_told_of(dog, stalls):
    in_a_thread(lets_others_run)
    assert [one for one in stalls if one.thread == "test lets_others_run"] == []


def test_a_callback_that_keeps_an_event_loop_is_told_with_the_line(dog, stalls):
    async def serve():
        lets_others_run()

    asyncio.run(serve())
    (stall,) = [one for one in stalls if one.kind == "event loop"]
    assert stall.seconds >= 0.3
    assert any("lets_others_run" in frame or "serve" in frame for frame in stall.where)


def test_afterwards_all_is_as_it_was(stalls):
    before = asyncio.Handle._run
    dog = Watchdog(stalls.append)
    assert asyncio.Handle._run is not before
    dog.close()
    assert asyncio.Handle._run is before


def test_stalls_of_a_process_go_into_a_file(tmp_path):
    file = tmp_path / "stalls.jsonl"
    with watch_stalls(file):
        asyncio.run(_kept())
    told = [json.loads(line) for line in file.read_text().splitlines()]
    assert {"kind", "seconds", "lasted", "at", "thread", "where"} == set(told[0])
    with pytest.raises(FileError), watch_stalls(tmp_path / "missing" / "stalls.jsonl"):
        pass


async def _kept():
    lets_others_run()


def test_a_stack_begins_with_the_innermost_frame():
    assert stack_of(None) == ()
    frames = sys_frames()
    assert frames[0].endswith("sys_frames")
    assert frames[1].endswith("test_a_stack_begins_with_the_innermost_frame")


def sys_frames():
    import sys

    return stack_of(sys._getframe())

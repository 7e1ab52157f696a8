"""`kill -9` at any moment: a session goes on before or after what was done, never in between."""

import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from os import kill
from pathlib import Path

import pytest
from idle import Idle
from patient import PATIENT
from waiting import PATIENCE

from workbench.app.core.state import Phase
from workbench.app.runtime.bench import Bench
from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.journal.journal import Journal
from workbench.plugins.robot_link import Simulation

HERE = Path(__file__).parents[1]
KILLS = 60
SESSIONS = 6
MOST_ENTRIES = 14
"""That a process makes from where it has taken up the session: those of a whole cycle."""

MOMENT = 0.005
"""[s] It lives for so long at most after the last of them; about as long as the next one takes."""


@pytest.fixture
def controller(cell):
    simulated = SimulatedController(cell, Simulation(speed=1000), patience=PATIENT)
    thread = threading.Thread(target=simulated.run)
    thread.start()
    yield simulated
    simulated.stop()
    thread.join()


@pytest.fixture
def nursery():
    """Starts processes that run cycles, without importing everything each time."""
    process = subprocess.Popen(
        [sys.executable, str(HERE / "killed_cycles.py")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        bufsize=1,
        cwd=HERE.parents[1],
        env={"PYTHONPATH": os.pathsep.join(sys.path), "PATH": ""},
    )
    assert process.stdout.readline() == "ready\n"
    yield process
    process.stdin.close()
    process.wait(PATIENCE)
    process.stdout.close()


def lived(nursery, folder, controller, entries, seconds) -> list[int]:
    """Have a process go on with a session and kill it; the entries that it said were done.

    It is killed so many seconds after it has said that of so many beside the one that it found.
    """
    nursery.stdin.write(f"{folder} {controller.port} {controller.state_port}\n")
    told: list[int] = []
    child = 0
    while not (child and len(told) > entries):
        line = nursery.stdout.readline().split()
        if line[0] == "pid":
            child = int(line[1])
        else:
            told.append(int(line[0]))
    time.sleep(seconds)
    kill(child, signal.SIGKILL)
    while line := nursery.stdout.readline().strip():
        told.append(int(line))
    return told


def test_a_session_killed_at_random_moments_is_always_whole(tmp_path, cell, nursery, controller):
    chance = random.Random(4)
    phases: Counter[Phase] = Counter()
    jobs = interrupted = 0
    for number in range(KILLS):
        folder = tmp_path / f"session-{number % SESSIONS}"
        told = lived(
            nursery, folder, controller, chance.randint(1, MOST_ENTRIES), chance.uniform(0, MOMENT)
        )
        journal = Journal(folder)
        # What was said to be done is there; what was in work is there wholly or not at all.
        assert journal.verify() == ()
        assert journal.count >= max(told)
        kinds = [row.kind for row in journal.entries()]
        was_sending = check_order(kinds)
        # Opening it replays every entry and compares the states that were recorded.
        bench = Bench(cell, journal, effects=Idle)
        state = bench.state
        assert state.job is None
        assert was_sending == str(state.fault).startswith("the workbench ended while sending")
        assert was_sending == (state.phase is Phase.FAULT)
        phases[state.phase] += 1
        interrupted += was_sending
        jobs += str(state.message).endswith("the workbench ended before the task was done")
        bench.close()
    # Otherwise the moments were not random enough to say anything.
    assert phases[Phase.FAULT] >= 5 and len(phases) >= 4 and jobs >= 5, (phases, jobs)
    # A kill hides at most the one message that was in the air.
    recorded = 0
    for number in range(SESSIONS):
        journal = Journal(tmp_path / f"session-{number}")
        recorded += sum(row.kind == "Sent" for row in journal.entries())
        journal.close()
    assert recorded <= controller.state()["received"] <= recorded + interrupted


def check_order(kinds: list[str]) -> bool:
    """No message without a sending, none of those without an approval since it and in this start.

    Returns:
        Whether the last sending has not ended.
    """
    is_approved = is_sending = False
    for kind in kinds:
        match kind:
            case "Approve":
                is_approved = True
            case "SendPlan":
                assert is_approved
                is_approved, is_sending = False, True
            case "Sent":
                assert is_sending
            case "LinkEnded":
                assert is_sending
                is_sending = False
            case "Opened":
                assert not is_sending
                is_approved = False
            case _:
                assert not is_sending
    return is_sending

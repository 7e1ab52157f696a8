"""The end of `workbench serve`: told whenever, first the robot, then what takes its time."""

import subprocess
import sys
from contextlib import contextmanager
from types import SimpleNamespace

from idle import Idle
from waiting import PATIENCE

from workbench.cli.main import main
from workbench.cli.serving import serve


def test_the_robot_is_stopped_before_places_of_anchors_are_waited_for(monkeypatch, tmp_path):
    ended = []

    class Noted(Idle):
        def __init__(self, cell, do, now, cell_file):
            super().__init__(cell, do, now)

        def run(self, effect):
            ended.append(type(effect).__name__)

    class Slow:
        def __init__(self, *_):
            pass

        def close(self):
            ended.append("anchors")

    @contextmanager
    def page(*_, **__):
        yield SimpleNamespace(link="")
        ended.append("page")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(serve, "_answers", lambda controller: True)
    monkeypatch.setattr(serve, "EffectRunner", Noted)
    monkeypatch.setattr(serve, "Anchors", Slow)
    monkeypatch.setattr(serve, "serve_with_front", page)
    monkeypatch.setattr(serve, "wait_for_the_end", lambda *lines: None)
    assert main(["serve", "--port", "0", "--users", str(tmp_path / "users.sqlite")]) == 0
    assert ended == ["StopSending", "page", "anchors"]


TOLD_ANYWHERE = """
import signal, sys, threading
from workbench.cli.serving.front import wait_for_the_end

last = max(line for _, _, line in wait_for_the_end.__code__.co_lines() if line)
told = False

def told_at(number):
    def trace(frame, event, argument):
        global told
        nonlocal number
        if event == "line" and signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
            if (frame.f_code, frame.f_lineno) == (wait_for_the_end.__code__, last):
                # It waits, and was not told yet: the one number that is too large.
                main = threading.main_thread().ident
                threading.Timer(0.5, signal.pthread_kill, [main, signal.SIGTERM]).start()
            number -= 1
            if number == 0:
                told = True
                signal.raise_signal(signal.SIGINT)
        return trace
    return trace

number, told = 0, True
while told:
    number, told = number + 1, False
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sys.settrace(told_at(number))
    wait_for_the_end("here")
    sys.settrace(None)
"""


def test_it_ends_wherever_in_it_the_signal_comes():
    ran = subprocess.run(
        [sys.executable, "-c", TOLD_ANYWHERE], timeout=PATIENCE, capture_output=True, text=True
    )
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.count("here") > 10

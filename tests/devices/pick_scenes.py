"""A pick server with a plan, robot programs that ask it, and a network that spoils bytes."""

import random
import socket
import threading
import time
from contextlib import contextmanager, suppress
from dataclasses import replace

import numpy as np
from patient import PATIENT
from ports import free_port
from waiting import PATIENCE, lasting

import workbench
from workbench.devices.pick_server.asking import Asker
from workbench.devices.pick_server.axes import axis_words
from workbench.devices.pick_server.conversation import VERSION
from workbench.devices.pick_server.lines import Form
from workbench.plugins.robot_link import Simulation, controller_by, link_named, send


def approved(**options):
    """A cell with a free port for its pick server, a plan, and its approval."""
    cell = workbench.read_cell("tx2_90")
    cell = replace(cell, controller=controller_by("pick-server", options=options))
    result = workbench.plan(cell, workbench.drop_parts(cell.parts[:1], cell.bin, seed=5))
    assert result.plan is not None, result.verdict
    return cell, result.plan, lasting(workbench.approve(cell, result.plan, result.proof, "tester"))


def elsewhere(cell, **options):
    """The cell with its pick server at a port that nobody has."""
    return replace(cell, controller=replace(cell.controller, port=free_port(), options=options))


def another(approval, number):
    """An approval of the same plan with a digest of its own, none of them in the future."""
    return replace(approval, at=approval.at - number * 1e-3)


class Sent(threading.Thread):
    """A sending in a thread: its receipts, and what ended it."""

    def __init__(self, cell, plan, approval, **words):
        super().__init__(daemon=True)
        self.receipts, self.error, self.shown = [], None, []
        self._given, self._over = (plan, approval, cell), threading.Event()
        usual = {"patience": PATIENT, "show": self.shown.append, "cancelled": self._over.is_set}
        self._words = {**usual, **words}
        self.start()

    def run(self):
        try:
            for receipt in send(*self._given, **self._words):
                self.receipts.append(receipt)
        except Exception as error:
            self.error = error

    def close(self):
        self._over.set()
        self.ended()

    def ended(self):
        self.join(PATIENCE)
        assert not self.is_alive()
        return self.receipts, self.error


@contextmanager
def program(cell, *faults, port=0, speed=200.0):
    """The simulated robot program of a cell, asking at that port."""
    wanted = Simulation("127.0.0.1", port, 0, speed, None, None, faults, float("inf"))
    began, running = threading.Event(), []

    def ready(one):
        running.append(one)
        began.set()

    link = link_named("pick-server")
    thread = threading.Thread(target=link.serve, args=(cell, wanted, ready), daemon=True)
    thread.start()
    assert began.wait(PATIENCE)
    try:
        yield running[0]
    finally:
        running[0].stop()
        thread.join(PATIENCE)
        assert not thread.is_alive()


class Program:
    """A robot program that jumps to where it has to be, and keeps what it was given."""

    def __init__(self, cell, port, form=None, again=0.2, run=1, version=VERSION):
        form = form or Form()
        self.axes, self.q = axis_words(cell, form), np.asarray(cell.arms[0].home)
        self.over = threading.Event()
        until = time.monotonic() + PATIENCE

        def is_over():
            return self.over.is_set() or time.monotonic() > until

        self.asker = Asker("127.0.0.1", port, form, run, is_over, again, version=version)
        self.got, self.plans = [], []

    def ask(self, job, *words):
        answer = self.asker.ask(job, *words)
        self.got.append((job, words, answer))
        return answer

    def joints(self):
        return self.axes.format(self.q)

    def begin(self):
        while (answer := self.ask("next", *self.joints()))[0] == "WAIT":
            time.sleep(0.005)
        assert answer[0] == "PLAN", answer
        self.plans.append(answer[1])
        return int(answer[2])

    def leg(self, number):
        """One leg up to its end, which is not reported yet."""
        leg = self.ask("leg", str(number))
        assert leg[0] == "LEG", leg
        for k in range(int(leg[4])):
            words = self.ask("point", str(number), str(k + 1))
            self.q = self.axes.read(words[1:7], in_motion=True)
        return leg

    def cycle(self):
        legs, held = self.begin(), False
        for number in range(1, legs + 1):
            leg = self.leg(number)
            if leg[2] == "grip":
                held = True
            elif leg[2] == "open" and held:
                assert self.ask("placed") == ("OK", "placed")
            assert self.ask("done", str(number), *self.joints())[0] == "OK"

    def close(self):
        self.over.set()
        self.asker.close()


@contextmanager
def spoiled(there, seed, *, often=3e-4):
    """A port from which bytes go to `there` and back: late, split, some lost and some twice."""
    chance, over, threads, links = random.Random(seed), threading.Event(), [], []
    counts = {"lost": 0, "twice": 0, "cut": 0}
    listener = socket.create_server(("127.0.0.1", 0))
    listener.settimeout(0.1)

    def carry(source, sink):
        with suppress(OSError):
            while not over.is_set():
                try:
                    data = source.recv(64)
                except TimeoutError:
                    continue
                if not data:
                    break
                out = bytearray()
                for byte in data:
                    drawn = chance.random()
                    counts["lost"] += drawn < often
                    counts["twice"] += often <= drawn < 2 * often
                    out += bytes([byte]) * ((drawn >= often) + (often <= drawn < 2 * often))
                if chance.random() < often * 5:
                    counts["cut"] += 1
                    break
                at = chance.randint(0, len(out))
                sink.sendall(out[:at])
                if chance.random() < 0.02:
                    time.sleep(0.003)
                sink.sendall(out[at:])
        for one in (source, sink):
            with suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)

    def accept():
        while not over.is_set():
            try:
                near, _ = listener.accept()
            except OSError:
                continue
            try:
                far = socket.create_connection(("127.0.0.1", there), 1)
            except OSError:
                near.close()
                continue
            for one in (near, far):
                one.settimeout(0.1)
                one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            links.extend((near, far))
            for pair in ((near, far), (far, near)):
                threads.append(threading.Thread(target=carry, args=pair, daemon=True))
                threads[-1].start()

    threads.append(threading.Thread(target=accept, daemon=True))
    threads[0].start()
    try:
        yield listener.getsockname()[1], counts
    finally:
        over.set()
        listener.close()
        for thread in threads:
            thread.join(PATIENCE)
        for one in links:
            one.close()

"""A controller with the RAPID modules, and how scenes handle it."""

import socket

from patient import Hurried
from waiting import wait_until
from wires import FOLDER, SPEED, TASKS, Talk

from workbench.devices.rapid.controller import Operator, RapidController
from workbench.formats.rapid.setup import read_setup

HOME = {"R": "0.00 -130.00 30.00 0.00 40.00 0.00 -135.00",
        "L": "0.00 -130.00 30.00 0.00 40.00 0.00 135.00"}  # fmt: skip
MID = {"R": "4.00 -126.00 30.00 0.00 40.00 0.00 -131.00"}
NEAR = {"R": "5.00 -125.00 30.00 0.00 40.00 0.00 -130.00",
        "L": "5.00 -125.00 30.00 0.00 40.00 0.00 130.00"}  # fmt: skip


class Stage:
    """A controller with the modules, and how it is handled."""

    def __init__(self, cell, speed=SPEED):
        self.clock = Hurried()
        self.operator = Operator(usual=1)
        self.one = RapidController(
            cell, read_setup(FOLDER), speed=speed, operator=self.operator, clock=self.clock
        )
        self.tickets = self.seen = 0

    def lines(self, module):
        """The text of a module."""
        tasks = self.one.setup.tasks.values()
        found = next(one for task in tasks for one in task.modules if one.path == module)
        return found.text.splitlines()

    def talk(self):
        talk = Talk(self.one.port)
        assert talk.say("hello abb-socket/2")[0] == "hello"
        return talk

    def load(self, talk, *steps, stands=HOME, counts=None, manner=""):
        """Tell a program; the last answer, and its ticket."""
        self.tickets += 1
        ticket = f"{self.tickets:016d}"
        legs = sum(step.startswith("leg") for step in steps)
        points = sum(step.startswith("to") for step in steps)
        legs, points = counts or (legs, points)
        lines = [f"plan {'a' * 64}", f"ticket {ticket} {legs:03d} {points:03d}{manner}"]
        lines += [f"start {arm} {stands[arm]}" for arm in TASKS]
        for line in [*lines, *steps]:
            answer = talk.say(line)
            if answer[0] != "ok":
                return answer, ticket
        return talk.say(f"end {points:03d} {talk.crc:04X}"), ticket

    def begin(self, *steps, stands=HOME, manner=""):
        """A program that runs."""
        talk = self.talk()
        answer, ticket = self.load(talk, *steps, stands=stands, manner=manner)
        assert answer[0] == "ok", answer
        answer = talk.say(f"run {ticket}")
        assert answer[0] == "ok", answer
        return talk

    def stepped(self, *steps):
        """A program that waits before its first step."""
        talk = self.begin(*steps, manner=" stepped")
        self.waits(talk, 1)
        return talk

    def waits(self, talk, number):
        """Until the robot waits before this step."""
        while talk.until("state").rest != f"waiting {number:02d} R00 L00":
            pass

    def refused(self, *lines):
        """A conversation that ends in a refusal; the reason."""
        talk = self.talk()
        for line in lines:
            answer = talk.say(line)
        assert answer[0] == "no", (lines, answer)
        assert talk.closed()
        return answer[1][5:]

    def restart(self):
        """The operator sets pointers to main; both arms come home."""
        self.one.do(self.one.start_anew)
        self.settle()

    def settle(self):
        """Until arms stand ready and T_LINK listens."""

        def ready():
            ended, order = self.one.shared["wb_ended"][0], self.one.shared["wb_order"][0]
            return all(self.one.shared["wb_ready"][0]) and ended == [order, order]

        wait_until(ready, "the arms to be ready")
        self.seen = len(self.one.written)
        holder, at = self.one.tasks["T_LINK"].loaded.globals["server"].place
        wait_until(lambda: holder[at].is_listening, "T_LINK to listen")

    def stopped(self):
        """T_LINK has stopped the arms, and waits for the operator."""
        wait_until(lambda: "Set the pointer" in " ".join(self.one.written[self.seen :]), "a stop")


def step(number, arm, mode, *points, hand="keep", opening=30.0, zone=0.2, ms=400, name="reach"):
    head = f"leg {number:02d} {arm} {name} {len(points):03d} {zone:.3f} {hand} {opening:.1f} {mode}"
    return [head, *(f"to {k:03d} {where} {ms:05d}" for k, where in enumerate(points, start=1))]


FORTH = step(1, "R", "alone", NEAR["R"], HOME["R"])
# To and fro for 4 s of real time: a busy machine must not come too late to break it off.
LONG = step(1, "R", "alone", *(NEAR["R"], HOME["R"]) * 20, ms=20000)


def stars(where):
    return "*" + "*".join(where.split()) + "*"


def old(stage, *messages, ends=False):
    """A conversation in `abb-socket`; whether the controller ends it after the last message."""
    talk = Talk(stage.one.port)
    link = talk.link
    for k, message in enumerate(messages):
        link.sendall(message.encode())
        try:
            answer = link.recv(4, socket.MSG_WAITALL)
        except ConnectionResetError:  # closed before all was read
            answer = b""
        is_last = k == len(messages) - 1
        assert answer == (b"" if ends and is_last else b"send"), (message, answer)
    if ends:
        link.close()
    return link

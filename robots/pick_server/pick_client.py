#!/usr/bin/env python3
# ruff: noqa: UP031, UP041
"""A robot program that asks Workbench's pick server, for Python 3.8 without libraries.

    python3 pick_client.py HOST PORT HOME...

HOME are the axes where the robot stands, in degrees.
Replace `Robot` by calls to your controller.  `docs/pick_server.md` has every byte.
"""

import random
import socket
import sys
import time

VERSION = "pick-server/1"
AGAIN = 1.0  # [s] after which a request without an answer is sent again
LAST = 9999


def check_of(text):
    """The check of a line."""
    value = 0
    for code in text.encode("ascii"):
        value = (value * 31 + code) % 65521
    return "%05d" % value


class Stop(Exception):
    """The robot may not go on."""


class Asker:
    """Asks until it has the answer; whatever is asked twice keeps its number."""

    def __init__(self, host, port):
        self.address, self.link, self.rest = (host, port), None, b""
        self.run, self.number, self.session = random.randint(1, LAST), 0, None

    def ask(self, *words):
        """The words of the answer to one job."""
        self.number = self.number % LAST + 1
        while True:
            try:
                if self.link is None:
                    self.connect()
                answer = self.answer_to(self.number, words)
            except OSError:
                self.close()
                time.sleep(0.1)
                continue
            if answer and answer[0] == "STOP" and words[0] != "stop":
                raise Stop(" ".join(answer))
            if answer:
                return answer

    def connect(self):
        """Connect and greet."""
        self.link = socket.create_connection(self.address, AGAIN)
        self.link.settimeout(0.05)
        self.rest = b""
        answer = self.answer_to(0, ("hello", VERSION, str(self.run)))
        if len(answer) != 4 or answer[0] != "OK":
            raise OSError("no greeting")
        if self.session not in (None, answer[2]):
            raise Stop("another server answers")
        self.session = answer[2]

    def answer_to(self, number, words):
        """The answer with this number; nothing where a line was damaged or lost."""
        text = " ".join((str(number),) + tuple(words))
        self.link.sendall(("%s %s\n" % (text, check_of(text))).encode("ascii"))
        until = time.time() + AGAIN
        while time.time() < until:
            try:
                data = self.link.recv(4096)
            except socket.timeout:
                continue
            if not data:
                raise OSError("closed")
            *lines, self.rest = (self.rest + data).split(b"\n")
            for line in lines:
                text, _, check = line.decode("ascii", "replace").rpartition(" ")
                if not text.isascii() or check != check_of(text):
                    return []
                heard, *answer = text.split(" ")
                if answer == ["ERR", "hello"]:
                    raise OSError("not greeted")
                if heard == "0" and answer[0] == "ERR":
                    return []
                if heard == str(number) and (number or answer[0] == "OK"):
                    return answer
        return []

    def close(self):
        """End the connection."""
        if self.link is not None:
            self.link.close()
        self.link = None


class Robot:
    """Replace this one: it moves nothing, and says where it would stand."""

    def __init__(self, home):
        self.axes = home

    def move(self, axes, speed, seconds):
        """Move all joints together, and stop there; axes are texts, as the line has them."""
        self.axes = axes

    def hand(self, what, opening):
        """Open or grip; return whether it holds a part."""
        return True

    def load(self, kilograms, centre):
        """Set what the flange carries."""

    def stop(self):
        """Brake."""


def wait_for(asker, robot, *words):
    """Ask for a job until it is done; a plan's words, or those of `OK`."""
    while True:
        answer = asker.ask(*words)
        if answer[0] != "WAIT":
            return answer
        asker.ask("state", *robot.axes)
        time.sleep(0.1)


def carry_out(asker, robot, plan):
    """One plan, leg by leg: a leg that was answered may be run once."""
    holds = told = False
    for leg in range(1, int(plan[2]) + 1):
        _, _, hand, opening, count, _, mass, x, y, z = asker.ask("leg", str(leg))
        points = [asker.ask("point", str(leg), str(k + 1)) for k in range(int(count))]
        gripped = robot.hand(hand, float(opening)) if hand != "keep" else None
        robot.load(float(mass), (float(x), float(y), float(z)))
        if hand == "grip":
            holds = gripped
        if hand == "open" and holds and not told:
            asker.ask("placed")
            told = True
        for point in points:
            robot.move(point[1:-3], float(point[-3]), float(point[-2]))
        asker.ask("done", str(leg), *robot.axes)
        if hand == "grip":
            if holds:
                asker.ask("picked")
            else:
                asker.ask("failed", "missed")


def main(host, port, *home, cycles=0):
    """Ask for plans, scanning in between; `cycles` 0: for ever."""
    asker, robot, done = Asker(host, int(port)), Robot(list(home)), 0
    while not cycles or done < cycles:
        try:
            plan = wait_for(asker, robot, "next", *robot.axes)
            if plan[0] == "PLAN":
                carry_out(asker, robot, plan)
                done += 1
            elif wait_for(asker, robot, "scan")[0] == "OK":
                wait_for(asker, robot, "find")
            else:
                time.sleep(0.1)
        except Stop as why:
            robot.stop()
            print("stopped:", why)
            if "server" not in str(why):
                asker.ask("stop")
            return 1
    asker.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

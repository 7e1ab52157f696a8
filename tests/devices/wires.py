"""One conversation on two controllers: random programs, good and bad, and what is said to them.

`python tests/devices/wires.py 200` runs so many on the simulated controller and on the RAPID
modules, and compares message by message.  Some of them are run step by step.
"""

import itertools
import socket
import sys
import threading
import time
from typing import ClassVar

import numpy as np

from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.devices.abb_socket.frames import (
    FIRST_CRC,
    TEXT,
    Frames,
    crc_of,
    make_frame,
    number_after,
)
from workbench.devices.abb_socket.messages import in_degrees
from workbench.devices.rapid.controller import Operator, RapidController
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.rapid.setup import read_setup
from workbench.model.motion import LEG_NAMES
from workbench.plugins.robot_link import LinkPatience, Simulation

PATIENCE = 300.0
FOLDER = find("robots", "yumi") / "rapid"
TASKS = {"R": "T_ROB_R", "L": "T_ROB_L"}
SPEED = 200.0


class Gone(Exception):
    """The controller has closed the link."""


class Talk:
    """A client that knows frames, and nothing of what they mean."""

    links: ClassVar[list[socket.socket]] = []
    """Of all of them, for who cleans up."""

    def __init__(self, port):
        until = time.monotonic() + PATIENCE
        while True:
            self.link = socket.socket()
            self.links.append(self.link)
            self.link.settimeout(PATIENCE)
            try:
                self.link.connect(("127.0.0.1", port))
                if self.link.recv(4, socket.MSG_WAITALL) == b"send":
                    break
            except OSError:
                pass
            self.link.close()
            assert time.monotonic() < until, "nobody listens"
            time.sleep(0.02)
        self.link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.frames, self.number, self.crc = Frames(), 0, FIRST_CRC
        self.others, self.heard, self.states = [], [], []

    def say(self, text, **changes):
        """Say something; the answer to it, as word and rest."""
        self.number = number_after(self.number)
        data = make_frame(changes.get("number", self.number), text)
        if text.split()[0] not in ("hello", "end", "run", "abort"):
            self.crc = crc_of(data[:TEXT].decode(), self.crc)
        if "crc" in changes:
            data = data[:TEXT] + changes["crc"] + b"\n"
        self.link.sendall(data)
        return self.answer()

    def next(self):
        """The next frame; raises `Gone` when there will be none."""
        while not self.heard:
            try:
                data = self.link.recv(4096)
            except ConnectionError:
                raise Gone from None
            if not data:
                raise Gone
            came = list(self.frames.hear(data))
            self.states += [frame.rest for frame in came if frame.word == "state"]
            self.heard.extend(came)
        return self.heard.pop(0)

    def answer(self):
        while True:
            frame = self.next()
            if frame.word in ("hello", "ok", "no", "stopped"):
                return frame.word, frame.rest
            self.others.append(frame)

    def until(self, *words):
        """Ping until one of these words comes; what came meanwhile is kept."""
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            for k, frame in enumerate(self.others):
                if frame.word in words:
                    return self.others.pop(k)
            while self.say("ping")[0] != "ok":
                pass
            time.sleep(0.02)
        raise AssertionError(f"none of {words} came, but {self.others}")

    def closed(self):
        """Whether the controller ends the link now."""
        try:
            while True:
                self.others.append(self.next())
        except Gone:
            return True
        finally:
            self.link.close()


def random_program(rng, cell, stands):
    """Lines of a program from where the arms stand, and where they stand after it."""
    letters = {arm.controller_id: arm for arm in cell.arms}
    stands, gripped, told = dict(stands), {}, set()
    steps = []
    for number in range(1, int(rng.integers(2, 6)) + 1):
        mode = str(rng.choice(["alone", "free", "sync"]))
        movers = [str(rng.choice(list(letters)))] if mode == "alone" else list(letters)
        points, zone = int(rng.integers(1, 5)), float(rng.choice([0.0, 0.1, 0.2, 0.45]))
        times = rng.integers(300, 900, points)
        for letter in movers:
            hand = str(rng.choice(["open", "grip", "keep"]))
            if (hand == "grip" and (letter in gripped or letter in told)) or (
                hand == "open" and letter in gripped and letter in told
            ):
                hand = "keep"
            opening = float(rng.integers(200, 480)) / 10
            if hand == "grip":
                gripped[letter] = opening
            elif hand == "open" and letter in gripped:
                gripped.pop(letter)
                told.add(letter)
            if mode != "sync":
                points = int(rng.integers(1, 5))
                times = rng.integers(300, 900, points)
            name = str(rng.choice(LEG_NAMES))
            head = f"{number:02d} {letter} {name} {points:03d} {zone:.3f}"
            steps.append(f"leg {head} {hand} {opening:.1f} {mode}")
            home = np.asarray(letters[letter].home)
            for k, ms in enumerate(times, start=1):
                near = stands[letter] + rng.uniform(-0.15, 0.15, len(home))
                stands[letter] = home + np.clip(near - home, -0.22, 0.22)
                where = " ".join(in_degrees(letters[letter], stands[letter]))
                steps.append(f"to {k:03d} {where} {ms:05d}")
    # As in every plan, a part that was taken is put down.
    for letter in gripped:
        number += 1
        where = " ".join(in_degrees(letters[letter], stands[letter]))
        steps.append(f"leg {number:02d} {letter} place 001 0.000 open 48.0 alone")
        steps.append(f"to 001 {where} 00300")
    return steps, stands


def lines_of(rng, cell, stands, ticket):
    steps, after = random_program(rng, cell, stands)
    legs = sum(line.startswith("leg") for line in steps)
    points = sum(line.startswith("to") for line in steps)
    digest = "".join(rng.choice(list("0123456789abcdef"), 64))
    starts = [
        f"start {arm.controller_id} {' '.join(in_degrees(arm, stands[arm.controller_id]))}"
        for arm in cell.arms
    ]
    head = [f"plan {digest}", f"ticket {ticket} {legs:03d} {points:03d}", *starts]
    if rng.random() < 0.5:
        head += [
            line
            for arm in cell.arms
            for of in ("tool", "part")
            for line in (
                f"load {arm.controller_id} {of} 0.134 0.0 -1.5 {rng.uniform(1, 200):.1f}",
                f"axes {arm.controller_id} {of} 0.7071 0.0000 -0.7071 0.0000 "
                "0.00004 0.00100 0.00010",
            )
        ]
    return [*head, *steps], points, after


def spoil(rng, lines):
    """One thing in a program is not as it should be."""
    lines = list(lines)
    at = int(rng.integers(1, len(lines)))
    word, *rest = lines[at].split()
    match str(rng.choice(["drop", "twice", "swap", "word", "count", "mode", "time", "letter"])):
        case "drop":
            del lines[at]
        case "twice":
            lines.insert(at, lines[at])
        case "swap":
            lines[at - 1], lines[at] = lines[at], lines[at - 1]
        case "word":
            lines[at] = " ".join([word, *rest[:-1]])
        case "count" if word in ("leg", "ticket"):
            k = 3 if word == "leg" else int(rng.integers(1, 3))
            rest[k] = f"{int(rest[k]) + 1:03d}"
            lines[at] = " ".join([word, *rest])
        case "mode" if word == "leg":
            rest[-1] = {"alone": "free", "free": "sync", "sync": "alone"}[rest[-1]]
            lines[at] = " ".join([word, *rest])
        case "time" if word == "to":
            rest[-1] = "00000"
            lines[at] = " ".join([word, *rest])
        case _:
            rest[0] = rest[0][:-1] if word == "ticket" else "Q"
            lines[at] = " ".join([word, *rest])
    return lines


def step_by_step(talk, lines):
    """Let each step of a program run when the robot waits before it; what was said."""
    said = []
    steps = max(int(line.split()[1]) for line in lines if line.startswith("leg"))
    for step in range(1, steps + 1):
        waits = f"waiting {step:02d} R00 L00"
        while talk.until("state").rest != waits:
            pass
        said.append(("waits", waits))
        # Its number says how often was asked before.
        word, rest = talk.say(f"next {step:02d}")
        said.append((word, "" if word == "ok" else rest[:4]))
    return said


def transcript(port, lines, points, ticket):
    """All that a controller answers to a program, but for when reports come; and how it ends."""
    talk, said = Talk(port), []
    try:
        said.append(talk.say("hello abb-socket/2"))
        for line in [*lines, None, f"run {ticket}"]:
            line = f"end {points:03d} {talk.crc:04X}" if line is None else line
            word, rest = talk.say(line)
            # Why is said in words of their own.
            said.append((word, rest[:4] if word == "no" else rest))
            if word == "no":
                return said, talk.closed(), ()
        if lines[1].endswith(" stepped"):
            said += step_by_step(talk, lines)
        done = talk.until("done", "fault")
        said.append((done.word, done.rest if done.word == "done" else ""))
        at = []
        for letter in TASKS:
            talk.others = [one for one in talk.others if one.word != "at"]
            at.append(next(f for f in iter(lambda: talk.until("at"), None) if f.rest[0] == letter))
        parts = sorted(f.rest for f in talk.others if f.word == "part")
        said += [("part", part) for part in parts]
        said.append(("states", check_states(talk.states, lines)))
        said += [("at", frame.rest) for frame in at]
    finally:
        talk.link.close()
    return said, False, at


def check_states(states, lines):
    """Whether reports only tell of what the program does: steps in order, waypoints that are."""
    legs = [line.split()[1:] for line in lines if line.startswith("leg")]
    most = {(int(leg[0]), leg[1]): int(leg[3]) for leg in legs}
    last = 0
    for state in states:
        phase, step, *arms = state.split()
        if phase == "waiting":
            assert lines[1].endswith(" stepped"), state
            assert last <= int(step) <= int(legs[-1][0]), state
            assert [int(one[1:]) for one in arms] == [0, 0], state
            last = int(step)
            continue
        if phase != "running":
            assert [int(step), *(int(one[1:]) for one in arms)] == [0, 0, 0], state
            continue
        assert last <= int(step) <= int(legs[-1][0]), state
        last = int(step)
        for arm in arms:
            assert int(arm[1:]) <= most.get((last, arm[0]), 0), state
    return "in order"


class Both:
    """The two controllers, both at home."""

    def __init__(self, cell):
        patient = LinkPatience(*[PATIENCE] * 5)
        self.simulated = SimulatedController(cell, Simulation(speed=SPEED), patience=patient)
        self.widths = dict.fromkeys(TASKS.values(), 0.0)
        self.rapid = RapidController(
            cell, read_setup(FOLDER), speed=SPEED, operator=Operator(usual=1)
        )
        self.rapid.closes_at = self._closes_at
        self.threads = [
            threading.Thread(target=one.run, daemon=True) for one in (self.simulated, self.rapid)
        ]
        for thread in self.threads:
            thread.start()

    def _closes_at(self, task):
        """A part is as wide as the leg says that the arm is about to run."""
        arm = list(TASKS.values()).index(task)
        get = self.rapid.shared
        step = get["wb_step"][0][arm]
        leg = get["wb_leg_step"][0][arm].index(step)
        return get["wb_leg_opening"][0][arm][leg] / 2

    def close(self):
        for one in (self.simulated, self.rapid):
            one.stop()
        for thread in self.threads:
            thread.join(PATIENCE)
        for link in Talk.links:
            link.close()


def same(one, other):
    """Whether two transcripts say the same; where arms stand, to a hundredth of a degree.

    Of a program that both refuse the modules may say so later, when it has all been told: steps are
    looked at as a whole.  Nothing has moved then.
    """
    if one[-1][0] == other[-1][0] == "no" and len(one) != len(other):
        shorter = min(len(one), len(other)) - 1
        one, other = one[:shorter], other[:shorter]
    assert len(one) == len(other), (one[-5:], other[-5:])
    for (word, rest), (word_, rest_) in zip(one, other, strict=True):
        assert word == word_, ((word, rest), (word_, rest_))
        if word != "at":
            assert rest == rest_, ((word, rest), (word_, rest_))
        else:
            a, b = (np.array(text.split()[1:], float) for text in (rest, rest_))
            assert rest[0] == rest_[0] and np.abs(a - b).max() < 0.0101, (rest, rest_)


def compare(cell, seeds, share_spoilt=0.4, share_stepped=0.25):
    """Run programs on both; how many there were of each end, and how many messages."""
    both = Both(cell)
    stands = {arm.controller_id: np.asarray(arm.home) for arm in cell.arms}
    ends, messages = {"done": 0, "no": 0, "stepped": 0}, 0
    try:
        for seed in seeds:
            rng = np.random.default_rng(seed)
            ticket = f"{seed:016x}"
            lines, points, after = lines_of(rng, cell, stands, ticket)
            if rng.random() < share_spoilt:
                lines = spoil(rng, lines)
            is_stepped = rng.random() < share_stepped and lines[1].startswith("ticket")
            lines[1] += " stepped" * is_stepped
            try:
                told = [
                    transcript(one.port, lines, points, ticket)
                    for one in (both.simulated, both.rapid)
                ]
                same(told[0][0], told[1][0])
                assert told[0][1] == told[1][1]
            except (AssertionError, Gone) as error:
                text = "\n".join(lines)
                raise AssertionError(f"seed {seed}: {error!r}\n{text}") from error
            end = "no" if told[0][0][-1][0] == "no" else "done"
            ends[end] += 1
            ends["stepped"] += is_stepped and end == "done"
            messages += len(told[0][0])
            if end == "done":
                stands = after
    finally:
        both.close()
    return ends, messages, both.rapid


def main():
    count = int(sys.argv[1])
    began, used = time.monotonic(), time.process_time()
    ends, messages, _ = compare(read_cell("yumi"), itertools.islice(itertools.count(1000), count))
    print(
        f"{count} programs, {messages} messages the same: {ends['done']} run, "
        f"{ends['stepped']} of them step by step, {ends['no']} refused by both; "
        f"{time.monotonic() - began:.0f} s, {time.process_time() - used:.0f} s of the "
        "processor"
    )


if __name__ == "__main__":
    main()

"""Both ends of an abb-socket/2 conversation in one process."""

import re

from workbench.devices.abb_simulated.serving import Serving
from workbench.devices.abb_socket.messages import REQUEST
from workbench.devices.abb_socket.program import program_of
from workbench.devices.abb_socket.sending import SocketSending

SWAPPED = {"right": "left", "left": "right", "R": "L", "L": "R"}


def as_begun(plan, text):
    """A text that is written as if the right arm began, for a plan that either may begin."""
    if plan.sequence[0].runs[0][0] == "right":
        return text
    letter = r"(?<= )[RL](?=\d| |-)"
    return re.sub(rf"\b(right|left)\b|{letter}", lambda found: SWAPPED[found[0]], text)


class Talk:
    """Both sides in one place; the clock is turned by hand."""

    def __init__(self, cell, plan, approval, *, released=lambda: None, tickets=None, away=0.0):
        self.program = program_of(cell, plan, approval)
        self.ours = SocketSending(cell, plan, self.program, now=lambda: 1000.0, released=released)
        standing = {name: q + away for name, q in self.program.starts.items()}
        self.theirs = Serving(cell, lambda: standing, [] if tickets is None else tickets)
        self.receipts = []
        self.at = 0.0

    def tell(self, text):
        """The controller says something."""
        self.hear(self.theirs.say(text))

    def hear(self, data):
        for receipt in self.ours.hear(data, self.at):
            self.receipts.append(receipt)

    def go_on(self, until="run"):
        """Load, up to and with a word."""
        if not self.receipts:
            self.hear(REQUEST)
        while data := self.ours.say(self.at):
            for frame, answer in self.theirs.hear(data):
                self.tell(answer)
                if frame.word == until:
                    return

    def report(self, step, first=0, second=0):
        """Where the arms are, the one that begins and the other."""
        words = f"state {self.theirs.phase} {step:02d} R{first:02d} L{second:02d}"
        self.tell(as_begun(self.ours._plan, words))

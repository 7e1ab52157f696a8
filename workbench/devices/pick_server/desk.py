"""Interface to scanning, search and planning: the pick server itself only delivers plans."""

from typing import Protocol

from workbench.devices.pick_server.lines import Request

Words = tuple[str, ...]


class Desk(Protocol):
    """Answers jobs that no plan is needed for; every call returns at once."""

    def answer(self, request: Request) -> Words:
        """What is answered to a job that no plan is needed for: `scan`, `find`, `recipe`, ...

        The first word is one of `lines.ANSWERS`; an answer `WAIT` asks to ask again.

        Raises:
            BadLine: a word of the request is none that the job has.
        """
        ...

    def phase(self) -> str:
        """Where the cycle stands, in one word."""
        ...

    def begin_anew(self) -> None:
        """Another run of the robot program begins: it gets no result of an earlier run."""
        ...


class NoDesk:
    """Of a server where people alone scan, find and plan, for instance `workbench send`."""

    def answer(self, request: Request) -> Words:
        """A plan may come; nothing else does."""
        return ("WAIT", "plan") if request.job == "next" else ("NO", "desk")

    def phase(self) -> str:
        """Nothing is known."""
        return "waiting"

    def begin_anew(self) -> None:
        """It has no jobs."""

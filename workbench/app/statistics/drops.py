"""What arms have dropped back, as people stated before what their hands held."""

from dataclasses import dataclass
from typing import Any

from workbench.model.tools.held_body import HeldAmount


@dataclass(frozen=True, slots=True)
class DropCount:
    """How often a hand was emptied: `parts` were dropped back, and `unknown` times some number."""

    times: int = 0
    parts: int = 0
    unknown: int = 0

    def __add__(self, other: "DropCount") -> "DropCount":
        """Both together."""
        return DropCount(
            self.times + other.times, self.parts + other.parts, self.unknown + other.unknown
        )


class Drops:
    """Counts what was dropped back, entry after entry.

    Concurrency: one thread.
    """

    def __init__(self) -> None:
        self.value = DropCount()
        self._held = ""

    def take(self, command: Any) -> None:
        """Take in a command in canonical form: the end of a planning, or of a sending."""
        if "plan" in command.get("result", ()):
            plan = command["result"]["plan"]["plan"]
            arms = () if plan is None else plan["arms"]
            self._held = next((arm["held"] for arm in arms if arm.get("held")), "")
        elif self._held and "fault" in command and not command["fault"]:
            parts = HeldAmount(self._held).parts
            self.value += DropCount(1, parts, int(parts == 0))

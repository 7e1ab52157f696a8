"""Faults of a simulated controller on demand, to see what our side makes of them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, cast, get_args

from workbench.model.errors import InputError

FaultName = Literal[
    "drop",
    "garbage",
    "slow",
    "half-open",
    "double-send",
    "wrong-arm",
    "emergency-stop",
    "pointer-lost",
    "start-refused",
    "empty-hand",
]
"""Link closed; nonsense said; late; silent but not closed; said twice; the other arm moves;
emergency stop; the programs of the arms lost their place; an arm is not where it has to start;
nothing is in the hand after it has closed."""

FAULT_NAMES: tuple[FaultName, ...] = get_args(FaultName)

STOPS: Mapping[FaultName, str] = {
    "emergency-stop": "emergency stop",
    "pointer-lost": "the program pointer of an arm is lost",
}
"""Faults that end a motion where it is."""

SLOW_SECONDS = 3.0
"""How late a slow controller answers."""


@dataclass(frozen=True, slots=True)
class Fault:
    """What goes wrong, and when: after this many messages of one connection.

    Under `abb-socket/2` `wrong-arm`, `emergency-stop` and `pointer-lost` count steps of the
    program; `empty-hand` counts how often hands close, in both protocols.
    """

    name: FaultName
    after: int = 1


def parse_fault(text: str) -> Fault:
    """A fault as typed: `NAME` or `NAME:n`.

    Raises:
        InputError: there is none of that name, or the number is none.
    """
    found = re.fullmatch(r"([a-z-]+)(?::(\d{1,4}))?", text)
    if found is None or found[1] not in FAULT_NAMES or found[2] == "0":
        raise InputError(
            f"fault {text!r} is not known: one of {', '.join(FAULT_NAMES)}, and from 1 on how many "
            "messages before, as in drop:3"
        )
    return Fault(cast(FaultName, found[1]), int(found[2] or 1))


class Faults:
    """The faults that are still to come; each comes once.

    Lifetime: as long as the controller.  Concurrency: one thread.
    """

    def __init__(self, faults: Sequence[Fault] = ()) -> None:
        self._left = list(faults)

    def is_due(self, name: FaultName, count: int) -> bool:
        """Whether a fault happens now, the `count`-th time that it could."""
        for fault in self._left:
            if fault.name == name and count >= fault.after:
                self._left.remove(fault)
                return True
        return False

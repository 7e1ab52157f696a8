"""How work tells how far it is, and hears that it shall end."""

from collections.abc import Callable

Report = Callable[[float, str], None]
"""Takes the share done, 0..1, and what is being done."""

Cancelled = Callable[[], bool]
"""Is asked now and then whether to give up."""


def silent(done: float, note: str) -> None:
    """Nobody wants to know how far it is."""


def never() -> bool:
    """Nobody gives up."""
    return False

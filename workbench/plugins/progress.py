"""How work states how far it is, and hears that it shall end."""

from collections.abc import Callable

from workbench.model.messages.message import Message

Report = Callable[[float, Message | str], None]
"""Takes the share done, 0..1, and what is being done."""

Cancelled = Callable[[], bool]
"""Is asked now and then whether to give up."""


def within(report: Report, begin: float, end: float) -> Report:
    """Progress of a part of the work, which begins and ends at these shares of the whole."""
    return lambda done, note: report(begin + (end - begin) * done, note)


def rising(report: Report) -> Report:
    """Progress that never falls: who looks a second time has not lost what is done."""
    most = 0.0

    def report_most(done: float, note: Message | str) -> None:
        nonlocal most
        most = max(most, done)
        report(most, note)

    return report_most


def silent(done: float, note: Message | str) -> None:
    """Nobody wants to know how far it is."""


def never() -> bool:
    """Nobody gives up."""
    return False

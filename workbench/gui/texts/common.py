"""Texts that several tabs share."""

from workbench.model.messages.message import Message, Text


class CommonText(Text, subject="page"):
    """Arms, parts, times and distances, and what pieces of a line are joined by."""

    NAME = "{name}"
    ARM = "{arm} arm"
    ADDRESS = "{host} port {port}"
    AT_LEAST = "at least {distance:mm}"
    TOUCHING = "touching"
    PARTS = "{count} {count:part|parts}"
    LENGTH = "{length:mm}"
    LENGTH_ROUNDED = "{length:mm0}"
    SECONDS = "{seconds:s}"
    CYCLE = "{cycle:s}"
    CYCLE_AND_BOUND = "{cycle:s}, {ratio:1} times the bound"
    PLAN_NUMBER = "Plan {number}"
    MORE = "and {count} more"
    LIST = "{items}"
    SENTENCE = "{text}."
    DEGREES_AXIS = "Axis {number} [deg]"
    AXIS = "Axis {number}"
    INTERNAL_ERROR = "Internal error, see the log."


def cycle_message(seconds: float, bound: float) -> Message:
    """The time of a plan [s], with how it compares with its bound, where that is known."""
    if bound > 0:
        return CommonText.CYCLE_AND_BOUND(cycle=seconds, ratio=seconds / bound)
    return CommonText.CYCLE(cycle=seconds)

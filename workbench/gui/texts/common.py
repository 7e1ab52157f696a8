"""Texts that several tabs share."""

from workbench.model.messages.message import Text


class CommonText(Text, subject="page"):
    """Arms, parts, times and distances, and what pieces of a line are joined by."""

    NAME = "{name}"
    ARM = "{arm} arm"
    ADDRESS = "{host} port {port}"
    AT_LEAST = "at least {distance:mm}"
    TOUCHING = "touching"
    PARTS = "{count} {count:part|parts}"
    PLAN_NUMBER = "Plan {number}"
    LIST = "{items}"
    SENTENCE = "{text}."
    AXIS = "Axis {number}"

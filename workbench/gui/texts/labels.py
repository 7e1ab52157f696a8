"""Labels of arms, parts, plans and distances, which several tabs show."""

from workbench.model.messages.message import Text


class LabelText(Text, subject="page"):
    """What things and measures are called in lines of the page, and how such pieces are joined."""

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

"""Labels of arms, parts, plans and distances, which several tabs show."""

from workbench.model.messages.message import Message, Text


class LabelText(Text, subject="page"):
    """What things and measures are called in lines of the page, and how such pieces are joined."""

    NAME = "{name}"
    ARM = "{arm} arm"
    LEFT_ARM = "Left arm"
    RIGHT_ARM = "Right arm"
    ADDRESS = "{host} port {port}"
    AT_LEAST = "at least {distance:mm}"
    TOUCHING = "touching"
    PARTS = "{count} {count:part|parts}"
    PLAN_NUMBER = "Plan {number}"
    LIST = "{items}"
    SENTENCE = "{text}."
    AXIS = "Axis {number}"


def arm_label(arm: str) -> Message:
    """An arm in a label: `Left arm`; other names than left and right stay as the cell has them."""
    known = {"left": LabelText.LEFT_ARM, "right": LabelText.RIGHT_ARM}.get(arm)
    return LabelText.ARM(arm=arm.capitalize()) if known is None else known()

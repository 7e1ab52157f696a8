"""Texts of the pages around the scene that hold values."""

from workbench.model.messages.message import Text


class BarText(Text, subject="bar"):
    """The robot in the bar above the scene, and logins."""

    ROBOT = "Robot: {state}"
    SIMULATED = "Simulated robot: {state}"
    SENDING = "Sending: robot {state}"
    SENDING_STEP = "Sending: robot {state}, step {number} of {total}"
    LOCKED_OUT = "Too many logins have failed. Try again in {minutes} min."

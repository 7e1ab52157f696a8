"""Texts of the dialog Approve, and of the line that shows approvals."""

from workbench.gui.texts.common import CommonText
from workbench.model.messages.message import Message, Text


class ApprovalText(Text, subject="page-approval"):
    """What a person approves, who has approved, and until when."""

    APPROVED_BY = "Approved by {people:and}"
    UNTIL = "By {people:and} until {until}"
    RUN_OUT = "run out"
    NOT_ALL_WATCHED = "not all of them have seen the preview"
    AT_SPEED = "at {share:%} of the planned speed"
    STEP_BY_STEP = "step by step"
    WAITING_FOR = "Waiting for {count} {count:person|people}."
    BY_WAITING = "By {people:and} until {until}, waiting for {count} more {count:person|people}."
    TITLE = "Approve this plan"
    TITLE_ROW = "Approve these {count} plans"
    AS = "Approve as {person}"
    AS_MANNER = "Approve as {person}, {manner}"
    ONE_AT_A_TIME = "{strategy}, one moves at a time ({guarantee})"
    TIME_INDEPENDENT = "{strategy}, proven for any speeds of both ({guarantee})"
    SYNCHRONISED = "{strategy}, proven at the planned times ({guarantee})"
    GRASP = "{part} ({kind}), grasp {grasp}"
    ARM_GRASP = "{arm} arm {part} ({kind}), grasp {grasp}"
    PROVEN_PLAN = "{cycle:s}, minimum clearance {clearance:mm}, plan {plan}, proof {proof}"
    ALL_SECONDS = "{cycle:s} in all"
    SPEED = "{cycle}, up to {share:%} of joint speeds"
    VALID = "{time:min} after the approval"
    PEOPLE = "{count} are needed; so far {people}"
    NOBODY = "nobody"
    COVERED = "the whole motion on {legs} legs, {waypoints} waypoints, {corners}"
    COVERED_FINGERS = (
        "the whole motion on {legs} legs, {waypoints} waypoints, {corners}, "
        "fingers opening and closing"
    )
    STOPS = "stops at each"
    ROUNDED = "corners sharp or rounded by up to {share:%} of a segment"
    STREAMED = "corners cut as streaming may"
    MEASURED = "{covered}; {count:n} positions checked"
    MEASURED_IN = "{covered}; {count:n} positions checked in {time:s2}, proof {proof}"
    MEASURED_ALONE = "{covered}; {count:n} positions checked, proof {proof}"
    PLAYED = "preview played to its end ({people})"
    NOT_PLAYED = "preview not played on a page"
    PLAYED_ELSEWHERE = "{played}; a program reports it for {people}"
    STANDS_AT_START = "is where the plan starts"
    NO_JOINTS = "reports no joint values: check that it is where the plan starts"
    CLEAR_OF = "cell, {things}, as the scan shows them"
    CLEAR_OF_POSES = "cell, {things}, as poses from outside state them"
    UNKNOWN_THINGS = "{count} unknown {count:thing|things} in the scan"
    ON_PALLETS = "{count} {count:part|parts} on pallets"
    AS_LEFT = "{clear}, each plan with what those before it leave"


def manner_message(speed_share: float, is_stepped: bool) -> Message | None:
    """The manner of a sending; None where it is in one go and as planned."""
    speed = ApprovalText.AT_SPEED(share=speed_share)
    if speed_share < 1.0 and is_stepped:
        return CommonText.LIST(items=(speed, ApprovalText.STEP_BY_STEP()))
    if speed_share < 1.0:
        return speed
    return ApprovalText.STEP_BY_STEP() if is_stepped else None

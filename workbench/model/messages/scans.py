"""Why a scan, a detection or an obstacle cannot be used, and what searches for parts report."""

from workbench.model.messages.message import Text


class ScanText(Text, subject="scan"):
    """Why a scan, a detection or an obstacle cannot be used."""

    SHAPE = "a scan needs points of shape (n, 3), n > 0, not {shape}"
    NOT_FINITE = "a scan may hold finite points only; drop the empty ones first"
    PIXELS = "{points} points but {pixels} pixels"
    COLOURS = "{points} points but colours of shape {shape}"
    ONLY_ROBOT = "the scan shows nothing but the robot: look at the view and the joints"
    COVARIANCE = "the covariance of a pose has six rows of six numbers"
    ROLL_AXIS = "the axis of a roll is a point and a direction of length 1"
    ROLL_POINT = "the axis of a roll goes through a point with finite coordinates"
    OBSTACLE_SIZE = "an obstacle needs three lengths above zero"
    PALLET_PART = "an obstacle that is a part on a pallet needs its kind and its pose"


class ObjectionText(Text, subject="objection"):
    """Why a hypothesis is not among the parts found, by the names of objections."""

    OUTSIDE = "outside the bin"
    TOO_LITTLE = "explains too little of the visible surface"
    FREE_SPACE = "violates free space"
    UNKNOWN = "something unknown explains it better"
    OUTDONE = "a part of another kind explains it and more"
    GOES_ON = "its surface continues where the part would end"
    COLOURS = "its colours are those of another kind"
    NOT_HELD = "a small shift explains it as well"
    CLAIMED = "another part explains its surface"
    TWIN = "a twin with a worse score"
    REACHES_INTO = "reaches into another part"
    RIVAL_FELL = "lost to a pose that was rejected as well"
    OF_PART = "{objection}: {part}"


class ScaleText(Text, subject="scale"):
    """What the parts found say of the size of a CAD file."""

    LARGE = "the CAD file of {part} seems {share}% too large for the scan"
    SMALL = "the CAD file of {part} seems {share}% too small for the scan"

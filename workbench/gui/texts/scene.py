"""Texts about places in the scene: where a plan is nearest, searches, the legend of the robots."""

from workbench.model.messages.message import Text


class NearestText(Text, subject="page-nearest"):
    """Where a plan comes nearest to something."""

    OF_PLAN = "plan {number}: {text}"
    FROM_EVERYTHING = "{distance} from everything"
    PLACE = "{distance}, {arm} arm on {leg}: {first} and {second}"
    PLACE_AT = "{distance}, {arm} arm on {leg} at {time:s2}: {first} and {second}"
    PLACE_IF = "{distance}, {arm} arm on {leg} at {time:s2} if {others:and}: {first} and {second}"
    OTHER_ARM = "the {arm} arm is then at its target of {time:s2}"
    REQUIRED = "required: {margin:mm}"
    LINEAR = (
        "{near}, {arm} arm on {leg} (required, and kept where checked: {margin:mm}; between "
        "checks proven to within {resolution:mm}; without the part taken and its support)"
    )
    AT_SLOT = (
        "{near}, {arm} arm on {leg} (required, and kept where checked: {margin:mm}; between "
        "checks proven to within {resolution:mm}; without tool and flange in the slot)"
    )
    PLANS = "plan {number}"
    CERTIFICATE = "certificate-{digest}.json"


class LegendText(Text, subject="page-legend"):
    """The legend over the scene: which robot is drawn how, and what ends the mode."""

    SHAPES = "Collision shapes: {where}"
    TRANSPARENT = "See-through: {where}"
    SOLID = "Solid: {where}"
    GREY = "Grey: {where}"
    SEARCH = "Violet: parts of search {number}, to be compared; not taken"
    ENDS_WITH_STEP = "Ends with Run step {number}, or Stop"
    REPORTED_LAST = "last reported at {at}; it may be elsewhere now"
    LOOK = "Look {direction}"
    LOOK_KEY = "Look {direction} (key {key})"


class WatchText(Text, subject="page-watch"):
    """Parts of a preview that still have to be watched."""

    NOT_WATCHED = "Not watched yet: {spans}"
    SPAN = "{begin:1} s to {end:1} s"
    OUT_OF_VIEW = "The grippers were out of view from {span}; play that part again"
    OUT_OF_VIEW_SEVERAL = "The grippers were out of view from {spans:and}; play these parts again"
    TIME = "{time:1} of {total:s}"


class SearchText(Text, subject="page-search"):
    """Searches for parts that are compared."""

    NONE_ABOVE = "none below {score:2}"
    SCORES = "scores {scores}"


class PosePageText(Text, subject="page-pose"):
    """The configuration of a candidate that the scene shows."""

    CLEAR_NEAR = "clear; on linear motion the tool keeps {margin:mm} from all but {part}"
    CLEAR_TOUCH = "clear; the tool may touch {part}"
    CLEAR_LEAVE = "clear; {part} may leave its support, but not come nearer"
    ELBOW = "grasp, elbow {number} of {count}"
    SOLUTION = "grasp, solution {number} of {count}"
    PAIR = "{first} and {second}, {distance:mm}"
    DRAGGED = "while you drag: {count} of {total} work, by gripper, reach and place"
    WORKING = "{count} of {total} work"
    STATION = "station {name}"

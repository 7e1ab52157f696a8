"""Texts of the tab Grasps."""

from workbench.model.messages.message import Text


class GraspText(Text, subject="page-grasps"):
    """The library of a part, its checks, symmetry, coverage, and copies of a grasp."""

    MORE = "and {count} more, not listed"
    POSSIBLE = "worked for {count} of {total} parts and arms"
    USES = "planned {planned}, taken {taken}, failed {failed}"
    TAKEN_OF = "{taken} of {planned}"
    FINDINGS = "with the {tool}: {findings}"
    TAKES = "the {tool} can take it, {facts}"
    HOLDS = "holds {width:mm}"
    CLEARANCE = "clearance {clearance:mm} on arrival"
    CHECKED = '"{name}": {text}'
    SYMMETRY = "Now: {symmetry}."
    MESH_SYMMETRY = "The mesh looks like: {symmetry}."
    NO_SYMMETRY = "no symmetry"
    ALIKE = "alike {turns:and} ({symmetry})"
    ALIKE_THROUGH = "alike {turns:and} through {point} mm ({symmetry})"
    FOLDS = "at {count} turns about {axis}"
    ANY_TURN = "at any turn about {axis}"
    TOO_HEAVY = "Left out for the weight: {count}; the firmest {finding}."
    PAIR = "{first} with {second}"
    PAIR_ORDERED = "{first} then {second}"
    COVERED = "A grasp works in {share:%} of {poses} orientations ({arms})."
    ARM_SHARE = "{arm} {share:%}"
    WORST = "Worst direction up: {direction} of the part, {share:%} of the orientations around it."
    HELPS = "This helps: a grasp for the {arm} arm, {share:%}."
    AXIS_OFF = "{axis} (to within {angle:deg0})"
    COPY = "Copy {number} of {count}, {name}: {pose}"
    MOVED = "moved {distance:mm}"
    TURNED = "turned {angle:deg1}"
    TURNED_MOVED = "turned {angle:deg1}, moved {distance:mm}"
    UNMOVED = "at its own pose"
    IN_BIN = "In the bin: {verdicts}"
    VERDICTS = "{verdict} {count}"
    POINT = "Marked point: x {x:mm}, y {y:mm}, z {z:mm}"
    POINT_AT_EDGE = "The part ends here. Marked point: x {x:mm}, y {y:mm}, z {z:mm}"
    NOTHING_NEW = "Nothing new that {tool} could hold well was found."
    BY_ARM = "By the {arm} arm"
    DRAFT = "An earlier session has left a draft with {count} {count:change|changes} not saved."
    APPLY_FIRST = 'apply or revert the fields of grasp "{name}" first, in the tab Grasps'
    MOVE_FIRST = (
        'press Move it there first, in the tab Grasps, or click on "{name}" to drop the numbers'
    )
    NUDGE = "Grasp 1 mm along {direction}"
    NUMBERS_EXPECTED = (
        "{name}: numbers are expected, as 0, 72, 144, or a count and a step, as 5 x 72 or "
        "3 x 13 from -28, not {text}"
    )
    COUNT_EXPECTED = "{name}: 1 to {most} numbers are expected, not {count}"
    NO_DIRECTION = "{name}: {vector} has no direction"

"""What proofs object to."""

from workbench.model.messages.message import Message, Text, found_part
from workbench.model.messages.plans import leg_message


class ViolationText(Text, subject="violation"):
    """A violation in one sentence: where, what, which bodies, how near."""

    BY_ARM = "arm {arm}: {problem}"
    ON_LEG = "arm {arm} leg {leg}: {problem}"
    AFTER = "arm {arm} leg {leg} after waypoint {waypoint}: {problem}"
    PAIR = "{violation}: {one} and {other}"
    CLEARANCE = "{violation}, clearance {far:mm}"


class ProofText(Text, subject="proof"):
    """What is wrong with a plan, or where it comes nearest to something."""

    NEAREST = "minimum clearance"

    OTHER_CELL = "the plan was made for another cell, or the cell has changed since"
    OTHER_SCAN = "the plan was made for another scan"
    UNKNOWN_PART = "the cell knows no part {part}"
    NO_ARM = "the plan moves no arm"
    USED_TWICE = "an arm or a part is used twice"
    UNKNOWN_ARM = "the cell has no arm {name}"
    UNKNOWN_TCP = "tool {tool} has no TCP {tcp}"
    NO_DETECTION = "there is no detection {number}"
    LEFT_OUT = "the plan leaves out {part} of the scan, or moves it"
    NOT_PUT_THERE = "{part} of the plan is not where a plan before puts it"
    NOT_IN_SCAN = "{part} of the plan is not in the scan"
    INVENTED_ROLL = "the plan states a roll of {part} that the scan does not show"
    OBSTACLE_LEFT_OUT = "the plan leaves out obstacle {obstacle} of the scan"
    INVENTED_PALLET = "the plan states that {obstacle} is a part on a pallet, which is not known"

    NOT_EVERY_LEG = "the sequence is not every leg once, in order"
    FOREIGN_ARM = "the sequence moves an arm that the plan does not"
    EMPTY_STEP = "a step of the sequence moves no arm"
    CROWDED_STEP = "a step of the sequence moves an arm twice, or more than two arms"
    NOT_IN_TURN = "the sequence does not move one arm after the other"
    OTHER_STRATEGY = "strategy {strategy} is not what the plan does: it moves {arms:and}"
    NEVER_AT_ONCE = "the plan is called {guarantee}, and never moves two arms at once"
    AT_ONCE = (
        "the arms of strategy {strategy} move one after the other; only the second's reach may run "
        "while the first goes home"
    )
    OTHER_JOINTS = "joints are not those of the arm, in their order: {joints}"
    OTHER_LEGS = "the legs are not {legs}"
    NO_SCANNER = "the arm carries no scanner that it could take to a view"
    NOT_ONLY_VIEW = "a plan that takes a scanner to its view does something else, too"
    NOT_ONLY_STIR = "a plan that stirs the parts in the bin does something else, too"
    NO_WALLS = "the bin has no walls that hold the parts while they are stirred"
    BESIDE_BIN = "{part} does not lie between the walls of the bin"
    NOT_ONLY_CHANGE = "a plan that changes a tool does something else, too"
    UNKNOWN_TOOL = "the arm cannot carry tool {tool}"
    SAME_TOOL = "the arm carries tool {tool} already"
    NO_SLOT = "tool {tool} of the arm has no slot"
    NOT_AT_SLOT = "is {off:mm} from the slot of {tool} where the tool is coupled or uncoupled"
    DEEP_IN_SLOT = "in the slot, contacts may be {most:mm} deep"
    OTHER_LEAVE = "does not go as the slot of {tool} states"
    NOT_ONLY_DROP = "a plan that drops back what a hand holds does something else, too"
    UNKNOWN_AMOUNT = "{held} is not what a hand can hold: {known:or} is expected"
    DROP_LINK = "robot link {link} opens or closes the hand before it begins"
    NOT_UP = "does not lead straight up out of the bin"
    OTHER_DROP = "ends {off:mm} from where the hand is to open"
    DROP_TIPPED = "ends with the hand {tilt:deg} off pointing down"
    DROP_OPENING = "the hand goes home with its fingers {opening:mm} open"
    STIR_OPENING = "the hand stirs with its fingers {opening:mm} open"
    BIN_LEFT_OUT = "the plan does not keep clear of the whole bin, which no scan shows"
    BREAKS = "does not start where the arm stands"
    SHAPES = "has waypoints of shape {waypoints} and times of shape {times}"
    NOT_FINITE = "holds a value that is not a finite number"
    WRONG_HOLDING = "states wrongly whether the part is in the hand"
    WRONG_MOTION = "is called {motion}, which it is not"
    JOINT_LIMIT = "joint {joint} at {at:deg} is outside {low:deg} to {high:deg}"
    TOO_FINE = "holds a configuration finer than what can be sent"
    STROKE = "finger opening {opening:mm} is outside the stroke"
    LATE_START = "does not begin at 0 s"
    TIMES = "has times that do not increase"
    EDITED = (
        "the file was changed after the plan was made: it states digest {stated}, its content has "
        "{actual}"
    )

    NO_LOAD_KNOWN = "the plan states a load, and the cell no mass of the tool {tool}"
    NO_LOAD_STATED = "the plan states no load, and the cell has that of {tool}"
    TOOL_LOAD = "the load of the tool is not that of the cell"
    PART_LOAD = "the load of the part is not that of the cell"

    NO_GRASP = "the part has no grasp {grasp}"
    OUTSIDE_REGIONS = "the part lies outside the regions of interest"
    NOT_AT_HAND = "the part is not where the hand closes"
    NOT_IN_HAND = "the part is not in the hand as grasp {grasp} takes it"
    GRASP_DISABLED = "grasp {grasp} is disabled"
    GRASP_FOR_ARMS = "grasp {grasp} is for arm {arms:or}"
    GRASP_FOR_TOOL = "grasp {grasp} is for tool {tool}"
    GRASP_FOR_TCP = "grasp {grasp} is for TCP {tcp}"
    OPENING = "fingers at {opening:mm}, the grasp asks for {wanted:mm}"
    OPENING_CHANGES = "does not begin with its fingers as reach has them"
    NO_PAIR = "grasps {first} and {second} are no pair of the part"
    OTHER_DIRECTION = "does not go in the direction of the grasp"
    NOT_STRAIGHT = "is not straight"

    PLACES_NEED_ROLL = "its places need the roll of the part, which is not known"
    NOT_HELD = "does not hold the part if it is turned by {angle:deg0} about its axis"
    TILTED = "the part is tilted by {tilt:deg1}; {most:deg1} are allowed"
    TILTS_TOO_LONG = "the part is near its largest tilt for too long to be proven"
    TOO_DEEP_ANY_TURN = "a part lies too deep in its support at every turn: the pose found is wrong"
    STAYS_ON = "a part does not come off its support at every turn"
    TOO_DEEP = "a part lies too deep in its support: the pose found is wrong"

    PLACE_TAKEN = "a part lies at that place of the pallet already"
    PART_ABOVE = "a part lies above it on the pallet, in layer {layer}"
    LAYER_OPEN = "layer {layer} of the pallet is not full: {empty} of {places} places are empty"
    NOTHING_BENEATH = "nothing is within {far:mm0} beneath the part when it is released"
    RELEASED_HIGH = "the part is released {falls:mm} above its support, {most:mm} at most"
    NO_WEIGHT = "the centre of mass of the part is unknown: its surface is not closed"
    STACK_FALLS = (
        "the part would not stand: a stack of {layers} falls over when tilted by {tilt:deg1}, "
        "{least:deg1} are required"
    )
    OTHER_APPROACH = "does not come in the direction of its place"
    NO_PLACE = "the hand opens where the arm has no place"
    PLACE_NEEDS_ROLL = "its place needs the roll of the part, which is not known"
    MISPLACED = (
        "the part is put down {far:mm} and {turn:deg1} from its target pose; {tolerance:mm} and "
        "{turn_tolerance:deg1} are allowed"
    )
    NO_BASE = "{part} comes onto {base}, and no {base} is known to stand in the assembly"
    IN_ASSEMBLY = "the assembly has its {part} already"
    ASSEMBLY_ROLL = "a part of unknown roll cannot be assembled"
    NOT_SEATED = "a point of the part ends {far:mm} from its seat; {most:mm} are allowed"
    OFF_INSERTION = (
        "a point of the part is {far:mm} off the straight line to its seat, {most:mm} at most"
    )
    INSERTION_LENGTH = "the straight motion to the seat is {length:mm} long instead of {wanted:mm}"
    NO_STATION = "the cell has no station {station}"
    STATION_ROLL = "a part of unknown roll must not be put on a station"
    OFF_STATION = (
        "the part is released {height:mm} above station {station}; 0 to {most:mm} are allowed"
    )
    OVER_EDGE = "the part stands over the edge of station {station}"
    FALLS_OVER = (
        "the part does not stand on station {station}: it falls over when tilted by {tilt:deg1}, "
        "{least:deg1} are required"
    )
    NOT_CARRIED = "nothing beneath the part on station {station} carries it"
    STANDS_IN = "the part would stand {depth:mm} deep in something on station {station}"

    TOO_FAST = "is faster than the joints may turn"
    TOO_HARD = "asks for more acceleration than the arm has"
    TOO_JERKY = "asks for more jerk than the arm may have"
    POINT_TOO_FAST = "moves a point faster than the cell allows: {most:mm/s} at most"

    NEVER_LEAVES = "the hand never leaves the part that it has released"
    TOO_MANY = "has too many waypoints beside leg {leg} of arm {arm} to be proven"
    NEARER_THAN_STATED = "comes nearer to something than was stated"
    NEAR_TOO_LONG = "is near something for too long to be proven"
    MARGIN = "within the safety margin of {margin:mm}"
    MARGIN_BESIDE = "within the safety margin of {margin:mm} while arm {arm} is on its leg {leg}"
    MAY_MOVE = "{stays} may move when {taken} is picked"


def violation_message(
    problem: Message,
    arm: str,
    leg: str,
    waypoint: int | None,
    pair: tuple[str, str] | None,
    distance: float | None,
) -> Message:
    """A problem with where it is, which bodies it has, and how close they come [m]."""
    said = problem
    if leg and waypoint is not None:
        said = ViolationText.AFTER(
            arm=arm, leg=leg_message(leg), waypoint=waypoint, problem=problem
        )
    elif leg:
        said = ViolationText.ON_LEG(arm=arm, leg=leg_message(leg), problem=problem)
    elif arm:
        said = ViolationText.BY_ARM(arm=arm, problem=problem)
    if pair is not None:
        first, second = map(found_part, pair)
        said = ViolationText.PAIR(violation=said, one=first, other=second)
    return said if distance is None else ViolationText.CLEARANCE(violation=said, far=distance)

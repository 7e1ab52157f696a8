"""What verdicts say: the reason, what meets what, and remarks for people."""

from workbench.model.messages.message import Text


class ReasonText(Text, subject="reason"):
    """The reasons of verdicts, by their names."""

    OK = "ok"
    DISABLED = "disabled"
    OUTSIDE_REGIONS = "outside the regions of interest"
    ARM_NOT_ALLOWED = "arm not allowed"
    NO_GRASP = "no grasp"
    NO_GRIP = "no grip"
    OUT_OF_STROKE = "outside the stroke"
    TOOL_COLLISION = "tool in collision"
    ROLL_UNKNOWN = "roll unknown"
    TILTED = "tilted"
    OUT_OF_REACH = "unreachable"
    IN_COLLISION = "in collision"
    APPROACH_BLOCKED = "approach blocked"
    EXTRACT_BLOCKED = "extraction blocked"
    NO_PATH = "no path"
    NO_RETURN = "no path back"
    NO_PLACE = "no place"
    OUT_OF_TIME = "out of time"
    WITHIN_MARGIN = "too close"


class StageText(Text, subject="stage"):
    """Where in the line a verdict was given."""

    PROPOSE = "preselection"
    GRASP = "grasp"
    APPROACH = "approach"
    EXTRACT = "extract"
    PLACE = "place"
    ROUTE = "route"


class VerdictText(Text, subject="verdict"):
    """A verdict in one sentence."""

    IN_HAND = "the part in the {arm} hand"
    PAIR = "{reason}: {one} and {other}"
    APART = "{reason}: {one} and {other}, {far:mm} apart"
    PENETRATING = "{reason}: {one} and {other}, penetration {depth:mm}"
    AWAY = "{reason}, {far:mm} away"
    NOTED = "{verdict} ({note})"
    FAILED_AT = "where it failed: {stage}"


class VerdictNote(Text, subject="note"):
    """Remarks of verdicts on candidates."""

    FINGERS = "finger opening {opening:mm0}"
    ONLY_ARMS = "only for arm {arms:or}"
    TOOL_IN_SLOT = "needs tool {tool}, which stands in its slot; the arm carries {carried}"
    OTHER_TOOL = "needs tool {tool}; the arm carries {carried}"
    OTHER_TCP = "needs TCP {tcp}, which tool {tool} does not have"
    CHANGE_TOOL = "needs tool {tool}; the arm carries {carried} and can change to it"
    STROKE = "opening {opening:mm0}, stroke {low:mm0} to {high:mm0}"
    STROKE_AND_TOLERANCE = "{stroke}; {room:mm} of the opening for the part's tolerance"
    AVOIDED_OTHERS = "another part goes to its place over a station"
    PICK_FAILED = "avoided since its pick failed"
    PICK_FAILED_SINCE = "avoided since its pick failed: {why}"
    TAKEN_LAST = "neighbours may move with it, so it is taken last"
    SPARE = "spare grasp: {grasp} works and has priority"
    NO_GRASP = "the parts found have no grasp for any arm; create one first"
    NO_GRIP = "no grasp of the tools fits there and holds the part"
    WORKS = "{facts}"
    WOULD_TILT = "the part would tilt too far"
    TILTED_THERE = "there the part would be tilted by {tilt:deg1}; {most:deg1} are allowed"
    LIES_TILTED = "it lies tilted by {tilt:deg1}; {most:deg1} are allowed"
    DURATION = "at least {seconds:s}"
    LIFT = "lift {lift}"
    AUTHORED = "as authored"

    ROLL_UNSEEN = "the scan does not show the roll, so every turn must work"
    PLACES_NEED_ROLL = "{count} {count:place|places} of arm {arm} need the roll"
    ALL_TURNS = "{parts:and} with the space of all turns: the scan shows no roll"
    STAYS_ON = "it does not come off at every turn"
    CUTS_INTO = "closed to {closed:mm0}, {body} is {depth:mm} inside the part at some turn"
    AT_SOME_TURN = "at some turn {problem}"
    MANY_FINGERS = "the hold of {count} fingers cannot be checked"
    NOTHING_HELD = "at some turn there is nothing between the fingers"
    WIDTH_VARIES = "{low:mm} to {high:mm} wide between the fingers, depending on the turn"
    OFF_CENTRE = "up to {aside:mm} off centre between the fingers, depending on the turn"
    INCLINED = "at some turn a finger meets a face inclined by {angle:deg0}"

    TOO_DEEP = "the part lies too deep in its support: the pose found is wrong"
    DEEP_IN_SLOT = "in the slot, contacts may be {most:mm} deep"
    NO_CONFIGURATION = "no joint configuration found from {starts} starts"
    LINE_ENDS = "the arm can follow {share:%} of the line"
    LIFTS_TRIED = "after {way:mm0}; {lifts} lifts tried"
    LIFT_ENDS = "after {way:mm0} of {whole:mm0}, lift {lift}"
    AT_END = "at the end of the leg"
    LEG = "leg {leg}"
    HELD_MEETS_ARM = "the ball of what is held meets arm {arm}: take the part out by hand"
    ARMS_MEET = "the arms meet: {legs:and}"
    ARM_LEG = "{arm} {leg}"

    NO_PLACE_FOR_ARM = "the cell has no place for this arm"
    NO_PLACE_FOR_PART = "{count} {count:place|places}, none for {part}"
    PLACES_UNREACHABLE = "the arm reaches none of its places"
    PLACE_NEEDS_ROLL = "the place needs the roll, which the scan does not show"
    NO_BASE = "no {base} is known to stand in the assembly; begin a new kit if it is missing"
    TARGET_POSES = (
        "{count} target {count:pose|poses}: part in collision {blocked}, unreachable {far}, "
        "arm too close {close}"
    )
    RETREAT_ENDS = "the hand can follow {share:%} of its retreat"
    ON_RETREAT = "while the hand retreats"
    PALLETS_FULL = "the pallets of arm {arm} are full: {places} places; report when they are empty"
    PALLETS_CLOSED = (
        "{taken} of {places} pallet places of arm {arm} have a part; the others lie below parts "
        "or have no support yet"
    )

    NEEDS_ARM = "strategy {strategy} needs a part for that arm; possible: {possible}"
    NEEDS_TWO_ARMS = "strategy {strategy} needs a part for each of two arms; possible: {possible}"
    BY_ARMS = "{part} by {arms:or}"

    INEXACT = "closer than the accuracy of the bodies, {excess:mm}"


class StationNote(Text, subject="station"):
    """Why a part cannot go to its place over a station."""

    NOT_OVER = "over a station: {why}"
    NO_POSE = "no pose on a station leads to a place"
    NO_GRASP = "no grasp brings it from the bin to a station: {reason}"
    NO_PATH_TO = "no path to the station: {verdict}"
    NO_PATH_FROM = "no path from the station: {verdict}"
    REFUSED_TO = "the proof refuses the path to the station: {violation}"
    REFUSED_FROM = "the proof refuses the path from the station: {violation}"

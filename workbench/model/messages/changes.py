"""What single changes of a cell are called, and what is said of a library that was filled."""

from workbench.model.messages.message import Text


class ChangeKindText(Text, subject="change-kind"):
    """Kinds of these changes, by the names of `CHANGE_KINDS`."""

    FINGERS = "fingers"
    GRASPS = "grasps"
    LIFTS = "lifts"
    MARGINS = "margins"
    BIN = "bin"
    ARMS = "arms"
    ORDER = "order"
    TOOL = "tool"


class ChangeText(Text, subject="change"):
    """Changes of a cell that are tried where a bin does not empty."""

    FINGERS_THINNER = "fingers {by:mm0} thinner"
    FINGERS_LONGER = "fingers {by:mm0} longer"
    AS_OPEN = "fingers as open as there is room"
    LESS_OPEN = "every grasp {by:mm0} less open on arrival"
    MORE_OPEN = "every grasp {by:mm0} more open on arrival"
    TILTED = "every grasp tilted by up to {by:deg0} more"
    MORE_TURNS = "every pattern with twice as many turns"
    SUGGESTED = "{count} suggested grasps as spares"
    LESS_DEEP = "every grasp {by:mm0} less deep as well"
    ALL_LIFTS = "all lifts, the first that is clear"
    UP_ALONE = "straight up alone"
    NEAR_MARGIN = "near_margin_mm halved"
    MARGIN = "margin_mm halved"
    WALLS_LOWER = "walls of the bin {by:mm0} lower"
    BIN_NEARER = "bin {by:mm0} nearer"
    BIN_FARTHER = "bin {by:mm0} farther away"
    BIN_TURNED = "bin turned by {by:deg0}"
    HOME_HIGHER = "home of every arm {by:mm0} higher"
    PLACES_HIGHER = "places {by:mm0} higher as well"
    PLACES_TURNED = "places turned by {by:deg0} as well"
    ORDER = "order {order}"
    TOOL = "arm {arm} with tool {tool}"
    CUP = "a cup of {by:mm0}"


class FillText(Text, subject="fill"):
    """What came of filling a library."""

    TAKEN = (
        "{taken} of {parts} parts in simulated piles come out, without a search for paths; "
        "{seconds:s} of processor time"
    )
    STAYS = "no grasp of the tools takes the others as they lie: {reasons}"
    COUNTED = "{count} {reason}"
    COVERED = "others lie on it"
    MORE_LIFTS = (
        'more lifts may take what cannot be lifted: emptying = "thorough" under [policy] in '
        "the cell file"
    )
    HELPS = (
        "no hand fits at {looked} parts that were examined; it fits at some of them with a "
        "change: {helps}"
    )
    HELPED = "{count} with {change}"
    NOTHING_HELPS = (
        "no hand fits at {looked} parts that were examined, nor with thinner fingers, lower walls "
        "or a cup of {cup:mm0}"
    )


class RemainText(Text, subject="remain"):
    """Parts that stayed in the bin when planning ended without a plan, and grasps for them."""

    WALLS = "{count} {part} beside a wall of the bin"
    NEIGHBOURS = "{count} {part} among other parts"
    FLOOR = "{count} {part} flat on the floor"
    WAYS = "{count} {part} with approach or lift blocked"
    REACH = "{count} {part} out of reach"
    OTHER = "{count} {part} elsewhere"
    ADDED = "{added} of {looked} {part} that were left can be taken with new grasps: {names}"
    KNOWN = "{known} of {looked} {part} that were left can be taken with the grasps of the library"
    NONE = "no grasp of the tools takes the {looked} {part} that were left as they lay"


class GraspChange(Text, subject="grasp-change"):
    """What differs between two grasp libraries."""

    GONE = "{name} is gone"
    NEW = "{name} is new"
    NEW_KIND = "{name} is new, {kind}"
    CHANGED = "{name}: {changes}"
    ORDER = "the order is another"
    SEARCH = "plans search grasps where none takes a part"
    NO_SEARCH = "plans search no grasps"
    PAIR = "the pair {first} with {second}"
    PAIR_ORDERED = "the pair {first} then {second}"
    GRASP = "a grasp"
    PATTERN = "a pattern of {count} grasps"
    DISABLED = "disabled"
    ENABLED = "enabled"
    MOVED = "moved by {by:mm2}"
    TURNED = "turned by {by:deg}"
    NO_PATTERN = "no pattern any more"
    REPEATED = "repeated as {kind}"
    PATTERN_CHANGED = "pattern changed, {before} → {after} grasps"
    AS_USUAL = "as usual"
    ANY = "any"
    OPENING_MM = "opening {before} → {after} mm"
    GRIP_MM = "grip {before} → {after} mm"
    APPROACH = "approach {before} → {after}"
    APPROACH_LENGTH_MM = "approach length {before} → {after} mm"
    RETREAT = "retreat {before} → {after}"
    RETREAT_LENGTH_MM = "retreat length {before} → {after} mm"
    PRIORITY = "priority {before} → {after}"
    ARMS = "arms {before} → {after}"
    TOOL = "tool {before} → {after}"
    FREE_ROTATION_DEG = "free rotation {before} → {after} deg"
    TILT_DEG = "tilt {before} → {after} deg"
    SLIDE_MM = "slide {before} → {after} mm"

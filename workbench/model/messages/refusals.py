"""Why a command is refused, and what to do instead."""

from workbench.model.messages.message import Text


class Refusal(Text, subject="refusal"):
    """Why a command is not in order now, or not for this person."""

    NOT_NOW = "{command} is not possible now: {missing}"
    TASK_RUNS = "{command} has to wait until {task} ends or is cancelled"
    MACHINES_ONLY = "{command} is reported by a machine, not by {person}"
    OTHER_ROLE = "{command} is for {role}; you are {yours}"
    IN_CONTROL = "{person} is in control; ask for control first"
    ACKNOWLEDGE_FIRST = "sending has to wait until an engineer acknowledges: {changes}"
    CHANGED = "this has changed since {since}: {changes}"
    CHANGED_MORE = "this has changed since {since}: {changes}; and {count} more"
    FAULT_FIRST = "{missing} ({fault})"
    NEEDS_NAME = "{command} needs a name: log in as somebody"
    NO_TASK = "no task is running"

    SCAN_FIRST = "finding parts is not possible now: take a scan first"
    NO_SCAN = "there is no scan to find parts in"
    NOTHING_TO_COMPARE = "no parts were found yet that another search compares with"
    NO_PARTS = "there are no parts to plan for"
    NO_PARTS_TO_STIR = "no part was found that a hand could stir"
    STIR_BESIDE_BIN = "{part} does not lie between the walls of the bin: take it out by hand"
    STIR_NO_WALLS = "the bin has no walls that hold the parts while a hand stirs them"
    STIR_NO_TIMES = "robot link {link} does not send times: it cannot stir slowly"
    STIR_JERK = "arm {arm} has jerk_deg: how fast it stirs cannot be proven"
    DROP_NO_LINK = "robot link {link} cannot begin a plan with a part in the hand"
    DROP_NO_JOINTS = "the controller does not report where arm {arm} stands"
    DROP_NO_PARTS = "the cell has no part: nobody knows how large what the hand holds is"
    DROP_NO_ARM = "the cell has no arm {arm}"
    DROP_OTHER_ARM = "arm {arm} is not at home: bring it home before the other one drops a part"
    DROP_SEVERAL_TCPS = "tool {tool} may hold a part at {tcps:or}: take it out by hand"
    DROP_RECIPE = "the hand may hold {parts:and}, which the recipe leaves out: choose one with all"
    DROP_KINDS = (
        "the hand may hold a longer or heavier part than the cell has now: take it out by hand"
    )
    DROP_OTHER_HOLDS = "arm {arm} may hold a part, too: empty it by hand and confirm it"
    HAND_MAY_HOLD = (
        "the hand of arm {arms:and} may still hold a part: press Drop back, or look and press "
        "Hands are empty"
    )
    HANDS_EMPTY = "no hand may hold a part, by what was sent last"
    DROP_AMOUNT = "the hand holds {known:or}, not {value}"
    NO_PLAN = "there is no plan; make a plan first"
    OTHER_PLAN = "the current plan is {plan}, not {named}: look at the current one and decide again"
    ONLY_COMPARED = "the next cycle needs parts that are taken, not only compared"
    NEXT_CYCLE_ASKED = "the next cycle starts already, as soon as the scanner's view is free"

    NO_PROOF = "the plan has no proof, so it cannot be approved"
    NO_PROVEN_PLAN = "there is no proven plan to approve"
    NO_APPROVED_PLAN = "there is no approved plan to send"
    PLAN_CHANGED = "the plan was changed after it was made; make a new one"
    CELL_CHANGED = "the cell has changed since the plan was made; make a new plan"
    OTHER_PROOF = "the proof is that of another plan; make a new plan"
    PROOF_OUTDATED = "the proof was made for another cell or scan; make a new plan"
    PROOF_FAILS = "the proof does not hold: {violation}"
    CORNERS_UNPROVEN = (
        "the controller rounds corners by {zone} of the segments, and the proof has not checked "
        "that; make a new plan"
    )
    NEWER_SCAN = "there is a newer scan than that of the plan; make a new plan"
    NOT_PLAYED = "the plan has not been played to its end; play it first"
    SPEED_SHARE = "a plan is sent at {least:%} to 100% of its speed, not at {share}"
    NO_MANNER = "step by step is either so or not, {value} is neither"
    NO_LOGIN = "{person} stands for people without a login; a person approves by their own name"
    NOT_APPROVED = "nobody has approved the plan"
    OTHER_APPROVED = "the approval is for another plan; have this one approved"
    CELL_CHANGED_SINCE = "the cell has changed since the approval; make a new plan"
    SCAN_SINCE = "there is a newer scan than that of the approval; make a new plan"
    APPROVAL_LAPSED = (
        "the approval by {person} was valid for {minutes} minutes and has run out; approve again"
    )
    CLOCK_SET_BACK = (
        "the approval by {person} has run out after {minutes} minutes, although the clock says "
        "otherwise: it was set back; approve again"
    )
    TOO_FEW_PEOPLE = (
        "the cell wants {count} different people to approve a plan, this one has {people}"
    )
    APPROVED_ALREADY = "{person} has approved already; {count} different people have to"

    OTHER_SCANS = "plans of a row are made after one scan, these are not"
    OTHER_ROW = (
        "the plans that follow this one are {plans}, not those that were named: look at the "
        "current row and decide again"
    )
    NOTHING_FOLLOWS = (
        "no plan follows this one, but some were named: look at the current row and decide again"
    )
    OTHER_ROW_APPROVED = "the approval is for another row of plans; have this one approved"
    LEFT_ON_STATION = (
        "plan {plan} puts a part on station {station}, and no plan that follows takes it from there"
    )
    ROW_NEEDS_REPORTS = (
        "the robot link {link} does not report what became of each part, so one plan can be sent "
        "at a time; shorten the row to one plan"
    )
    ROW_NEEDS_JOINTS = (
        "the controller reports no joints, so nobody knows where the robot stands between two "
        "plans; shorten the row to one plan"
    )
    ROW_LENGTH = "the row can have 1 to {most} picks, not {count}"
    ROW_IS_SO_LONG = "the row has {count} {count:pick|picks} already"

    OTHER_THRESHOLD = (
        "the plan was made with a threshold of {planned:mm0}, now it is {wanted:mm0}; make a new "
        "plan"
    )
    PALLET_CHANGED = (
        "a part that the plan counts on does not lie on the pallet any more, or nobody knows "
        "whether it does; make a new plan"
    )
    JOINT_UNKNOWN = (
        "nobody knows where the robot stands: axis {axis} of the {arm} arm is reported at {value}"
    )
    ROBOT_MOVED = (
        "the robot has moved: axis {axis} of the {arm} arm stands {off:deg} from where the plan "
        "starts, so that a point of the arm may be {away:mm} away; {allowed:mm} are allowed "
        "(margin_mm); bring it back"
    )

    SCANNER_UNKNOWN = (
        "nobody knows where the scanner is: the controller does not report the joints of the {arm} "
        "arm"
    )
    NOT_AT_VIEW = (
        "the {arm} arm does not stand at view {view}: axis {axis} is {off:deg} from there, so that "
        "a point of the arm may be {away:mm} away; bring it to the view"
    )
    SCAN_WITHOUT_JOINTS = (
        "nobody knows from where the scan was taken: it has no joints of the {arm} arm, which "
        "carries the scanner; take a scan"
    )
    SCAN_OF_OTHER_POSE = (
        "the pose of the scan does not follow from its joints of the {arm} arm; take a scan"
    )
    SCANNER_STANDS = "the scanner of cell {cell} hangs on no arm: there is no path to a view"
    OTHER_VIEW = "the scanner has no view {view}; it has {known}"
    VIEW_NOT_CHOSEN = "scans are taken from view {chosen}; choose view {view} first"
    OTHER_START = "no path begins at {start}; it begins at {known}"
    AT_VIEW = "the {arm} arm stands at view {view} already"
    NOT_AT_HOME = (
        "the path to the view begins at home (home_deg) or another view: axis {axis} of the {arm} "
        "arm stands {off:deg} from home, so that a point of the arm may be {away:mm} away; bring "
        "it there"
    )
    MOVED_SINCE_SCAN = (
        "the robot has moved since the scan: axis {axis} of the {arm} arm stands {off:deg} from "
        "there, so that a point of the arm may be {away:mm} away; scan again"
    )
    OTHER_CARRIER = "the {carrier} arm carries the scanner, not the {arm} arm"
    PLATE_SCAN_MOVED = (
        "the {arm} arm does not stand still where the plate is scanned: axis {axis} stands "
        "{off:deg} from there, so that a point of the arm may be {away:mm} away; scan the plate "
        "again"
    )
    SCANS_AFTER_THE_END = (
        "the {arm} arm carries the scanner and still works; go on when the plan has ended"
    )

    NOT_STEPPED = "the plan is not sent step by step"
    WAITS_NOWHERE = "the robot does not wait before a step now; wait until it stands"
    OTHER_STEP = "the robot waits before step {step}, not {named}: look and decide again"
    STEPS_LAPSED = (
        "nobody has let a step run for {minutes} minutes, or the clock was set back: the approval "
        "holds no longer; stop, and begin with a new scan"
    )

    NOTHING_PICKED = "there is no plan whose parts were picked"
    NO_OUTCOME = "a pick has succeeded or failed, {value} is neither"
    MOVED_BY_A_MISS = "a missed grip may have moved parts of this scan: take a new scan"
    OTHER_RESULT = "the result {result} does not fit is_picked = {is_picked}"
    OTHER_PARTS = "the plan does not take that part; it takes {parts}"
    SAID_ALREADY = "{person} has reported that already"
    NOTHING_AVOIDED = "no part is avoided"


class PosesRefusal(Text, subject="poses"):
    """Why approval is not switched off, or nothing goes out without it."""

    PATHS = "approval stays on: the robot link {link} sends paths, which somebody has to approve"
    IS_ON = "approval is on: somebody has to approve the plan"
    ROW = "approval is off for single plans alone: somebody has to approve this row"
    NO_SWITCH = "approval is switched by true or false, not by {value}"


class ChangeRefusal(Text, subject="cell-change"):
    """Why the cell, its parts or the session are not changed."""

    CELL_AS_IT_WAS = "nothing of the cell was changed"
    CELL_CHANGED = "the cell was changed by somebody else in the meantime; look and do this again"
    PAIRS_CHANGED = (
        "the pairs of grasps of part {part} were changed by somebody else in the meantime; look "
        "and do this again"
    )
    PART_AS_IT_WAS = "nothing of part {part} was changed"
    NO_UNDO = "there is no change of the cell to undo"
    NO_REDO = "there is no change of the cell to redo"
    SAVED_ALREADY = "the cell is saved already"
    PALLETS_EMPTY = "the pallets are empty already"
    FIND_FIRST = "find parts in a scan first: it shows their size"
    PART_EXISTS = "the cell has a part {part} already; choose another name"
    TOOL_EXISTS = "the cell has a tool {tool} already; choose another name"
    MOST_PARTS = "a cell has up to {most} parts"
    MOST_TOOLS = "an arm has up to {most} tools"
    NO_CAD = "{file} is no CAD file: one of {kinds} is"
    FILE_SIZE = "{file} has {bytes} bytes; up to {most} MB are taken"
    SOLID_NAME = "the name of a solid has up to {most} letters"
    PART_TWICE = "each part is named once, not {parts}"
    HOME_OUTSIDE = "the home of the {arm} arm lies outside its limits"
    WAITS_AT_VIEW = "the {arm} arm waits at view {view} with the scanner; change the cell file"
    MOST_POSES = "up to {most} poses are taken"
    SAME_POSE = "the {arm} arm stands as in {pose}, so another scan adds nothing: move it first"
    MOST_POSES_TAKEN = "up to {most} poses are taken; remove one of them first"
    NOTHING_CHANGED = "nothing has changed that nobody has acknowledged"
    OTHER_CHANGES = (
        "what runs now has the digest {digest}, not {named}: look at the current changes and "
        "decide again"
    )
    STRATEGY = "strategy {strategy} is not one of {known} in cell {cell}"
    CELL = "cell {cell}: {problem}"
    ROW_ORDER = (
        "plan {number} of the row cannot follow plan {before}, since nobody knows how the parts "
        "lie then: {why}"
    )
    TOOL_ROW = "plan {number} of the row changes a tool: send it alone, then plan with the new tool"
    NO_PAIR_GAP = "the cell has no pair_gap_mm"
    NOTE_EMPTY = "the note is empty"
    MOST_GRASPS = (
        "with all copies of patterns and symmetry the part would have {count} grasps; {most} are "
        "allowed"
    )
    GRASP_GONE = "grasp {grasp} does not exist any more; somebody has removed it"
    GRASP_CHANGED = "grasp {grasp} was changed by somebody else in the meantime"
    GRASP_TWICE = "the grasp name {grasp} would be used twice"


class ControlRefusal(Text, subject="control"):
    """Why control does not pass from one person to another."""

    YOURS = "you are in control already"
    NOBODYS = "nobody is in control"
    FREE = "nobody is in control; take it"
    ASKED_ALREADY = "you have asked already; {person} has not answered yet"
    TOO_MANY_ASK = "{count} people have asked already; wait until one of them has an answer"
    NOT_ASKED = "{person} has not asked for it; {others} has"
    NOBODY_ASKED = "{person} has not asked for it; nobody has"
    OTHER_PERSON = "{person} is not in control, {other} is"
    NOT_YOURS = "{person} has to give control back, not {other}"


class ValueRefusal(Text, subject="value"):
    """Why a value of a command cannot be used."""

    PERSON = "a person's name is needed, 1 to {most} printable characters, not {value}"
    MACHINE = "{person} is the name of a machine; a person has to ask for this"
    INTEGER = "{name} must be a whole number from {lowest} to {highest}, not {value}"
    NUMBER = "{name} must lie between {lowest} and {highest} {unit}, not {value}"
    RATIO = "{name} must lie between {lowest} and {highest}, not {value}"
    TEXT = "{name} must be a text of up to {most} printable characters, not {value}"
    AMONG = "{name} {value} is not known; there are {known}"
    POSES = "1 to {most} poses are needed, not {count}"
    JOINTS = "{count} joint values within the limits of {arm} are needed"
    FAR = "{thing}: {far} m away; {most} m are allowed"

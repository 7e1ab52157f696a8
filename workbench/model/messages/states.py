"""What state lines say, and why parts stay in the bin of a simulation."""

from workbench.model.messages.message import Message, Text


class TaskText(Text, subject="task"):
    """The tasks of the worker, by their names."""

    SCAN = "the scan"
    LOCALIZE = "the search for parts"
    PLAN = "the planning"
    VIEW = "the planning of the path to the view"
    STIR = "the planning to stir the parts"
    CHANGE = "the planning to change the tool"
    DROP = "the planning to drop back what the hand holds"
    SIGHT = "the scan of the plate"
    BALLS = "the scan of the balls"
    IMPORT = "the new part"
    TOOL = "the new tool"
    CORRECT = "the correction of the part"
    EMPTYING = "the emptying"
    OTHER = "the task {name}"


def task_message(name: str) -> Message:
    """A task of the worker for people."""
    known = {text.name.lower(): text for text in TaskText if text is not TaskText.OTHER}
    return known[name]() if name in known else TaskText.OTHER(name=name)


class HeldText(Text, subject="held"):
    """What a hand holds, as a person states it."""

    ONE = "one part"
    TWO = "two parts"
    UNKNOWN = "unknown"


def held_message(held: str) -> Message:
    """What a hand holds, for people."""
    return HeldText[held.upper()]()


class StateText(Text, subject="state"):
    """What happened last."""

    TASK_FAILED = "{task} failed: {why}"
    TASK_CANCELLED = "{task} was cancelled"
    CANCELLED_BY = "{task} was cancelled by {person}"
    FOUND = "{count} {count:part|parts} found"
    NOTHING_FOUND = "no part found"
    POSES_REFUSED = "poses from outside cannot be used: {problem}"
    CELL_REFUSED = "the cell file cannot be used, the cell stays as it was: {problem}"
    ENDS_HERE = "no further cycle starts"
    ENDS_AFTER_TASK = "no further cycle starts after this task"
    NEXT_CYCLE = "for the next cycle: {message}"
    NO_PLAN = "no plan: {verdict}"
    NO_DROP = (
        "no safe way to drop back was found: take the part out by hand, then press Hands are "
        "empty ({verdict})"
    )
    NOT_PROVEN = "a plan was found, but its proof does not hold: {violation}"
    NO_PROOF = "a plan was found, but it has no proof"
    PLAN_READY = "plan ready: {strategy}, {cycle:s}, {clearance}"
    HOME_PLANNED = "the path from the view home is planned: {cycle:s}, {clearance}"
    VIEW_PLANNED = "the path to view {view} is planned: {cycle:s}, {clearance}"
    CHANGE_PLANNED = "the {arm} arm can change its tool for {tool}: {cycle:s}, {clearance}"
    TOOL_CHANGED = "the {arm} arm carries {tool} now: save the cell, and scan"
    TOOL_STATED = "{person}: the {arm} arm carries {tool}"
    STIR_PLANNED = "the {arm} arm can stir the parts: {cycle:s}, {clearance}"
    NO_STIR = "no plan to stir the parts: {verdict}"
    STIRRED = "the parts are stirred: scan again"
    DROP_PLANNED = "the {arm} arm can drop back what it holds ({held}): {cycle:s}, {clearance}"
    DROPPED_BACK = "the {arm} arm has dropped back what it held: check the hand, then scan"
    SCANNED = "scan with {points} points"
    COMPARED = "search {number} found {count} {count:part|parts}; compare, then take them over"
    PARTS_FROM_OUTSIDE = "{change}, by {person}"
    PLATE_SEEN = "{pose}: plate found ({count} in all)"
    PLAYED = "the preview was played to its end"
    PLAYED_BY_REPORT = "a program reports that {person} saw the preview to its end"
    PLAN = "plan {plan}"
    PLAN_AND_ROW = "plan {plan} and {count} after it"
    ROW_LENGTH = "{person} limits this row to {count} of {total} picks"
    VOTED = "approved by {people:and}, {count} of {total} people"
    APPROVED = "{plan} approved by {people:and}"
    TO_BE_SENT = "{what}, to be sent {manner}"
    UNSEEN = "no page has shown it to {people:and}"
    SENDS = "{person} sends {plan}"
    STOPS_SENDING = "{person} stops the sending"
    MESSAGES_SENT = "{count} of {total} messages sent"
    STEP = "step {number} of {total}, {legs}"
    ROBOT_WAITS = "the robot waits before {step}"
    ROBOT_RUNS = "the robot runs {step}"
    STEP_LET = "{step}, released by {person}"
    NEXT_PLAN = "plan {number} of {total} follows"
    NEXT_CYCLE_AT_END = "the next cycle starts when this plan ends"
    NEXT_CYCLE_FROM = "the next scan follows at step {step}, with the robot out of view"
    OUT_OF_VIEW = "the robot is out of view: scanning for the next cycle"
    CYCLE_FINISHED = "cycle finished, {count} of {total} {total:part|parts} reported placed"
    REACHED_HOME = "the {arm} arm stands at home; go to the view before the next scan"
    REACHED_VIEW = "the {arm} arm stands at view {view}: scan"
    REST_KNOWN = (
        "the grip closed on nothing; {count} {count:part is|parts are} left in this scan "
        "to plan for"
    )
    ARM_FAILED = "{arm} arm failed: {why}"
    FAULT_WHILE_SENDING = "fault while sending: {fault}"
    FAULT_ACKNOWLEDGED = "fault acknowledged by {person}; take a new scan"
    FAULT_HANDS = (
        "fault acknowledged by {person}; empty the hands and confirm it, or drop back; then scan"
    )
    MAY_HOLD = "May hold a part: {hands}."
    HAND = "{arm} hand"
    HAND_PARTS = "{arm} hand ({parts:or})"
    PICKED = "{person} reports: {part} was picked"
    PICK_FAILED = "{person} reports: {part} failed"
    PART_DROPPED = "{person} reports: {part} was dropped; it may lie anywhere, so look and scan"
    TWO_PARTS = "{person} reports: a second part came with {part}; take it out of its place"
    SINCE = "{what}: {why}"
    NOTHING_AVOIDED = "no part is avoided now"
    MAKING_PART = "importing part {part} from {file}"
    MAKING_TOOL = "importing tool {tool} from {file}"
    CORRECTING = "measuring {part} in the scan"
    PART_MADE = 'part "{part}" is in the cell, {size} mm; plans search its grasps'
    TOOL_MADE = "the {arm} arm carries tool {tool}; check its TCP"
    EMPTYING = "emptying {piles} {piles:pile|piles} of {parts} {parts:part|parts} in simulation"
    DRAFT_DROPPED = "draft of {part} discarded"
    SAVES_CELL = "{person} saves the cell"
    SAVE_AGAIN = "saved, without the changes made meanwhile: save again"
    APPROVERS = "a plan needs {count} different approvers now"
    PALLETS_EMPTY = "the pallets are empty"
    HANDS_EMPTY = "{person} has seen the hand of {arms:and} empty"
    OPENED_AGAIN = "session opened again: earlier previews and approvals are void"
    CHANGES_ACKNOWLEDGED = "{person} acknowledged the changes since {since}"
    NOTE = "{person} notes: {text}"
    SCANNING = "scanning"
    SCANNING_PLATE = "scanning the plate"
    SEARCHING = "searching for parts"
    PLANNING = "planning"
    EMPTIED = (
        "{taken} of {parts} {parts:part|parts} taken out of {piles} {piles:pile|piles} in "
        "simulation"
    )
    CHANGES_TRIED = "{emptied}; {count} {count:change|changes} tried"
    NOT_AHEAD = "the next cycle was not prepared: {why}"
    PICKS_FAILED = "{count} picks in a row have failed; check bin, grippers and grasps"
    MORE_PLANS = "{count} more {count:plan|plans} in the row"


class PosesText(Text, subject="poses-state"):
    """Vision only: the robot's program gets poses alone, and moves by itself."""

    UNPROVEN = "vision only: nothing of the robot's motion is proven"
    SENDS = "{person} sends the poses of {plan}; nothing of the robot's motion is proven"
    OFF = "{person} has switched approval off: poses go out that nobody has approved"
    ON = "{person} has switched approval on"
    RELEASED = (
        "the poses of plan {plan} go out without approval, which {person} has switched off; "
        "nothing of the robot's motion is proven"
    )


class AheadText(Text, subject="ahead"):
    """Why the next cycle is not prepared while a plan is sent."""

    CANCELLED = "cancelled by {person}"
    PLAN_STOPPED = "the plan is stopped"
    NOT_AS_PLANNED = "the plan has not ended as planned"
    ROW_ENDED = "the row has ended early"
    CONTROL_GONE = "nobody, or somebody else, is in control now"
    PICK_FAILED = "a pick has failed, so somebody has to check"
    NOT_ALL_PICKED = "the robot has not reported every part as picked"
    OTHER_PLACES = "the places are not as expected"


class ControlText(Text, subject="in-control"):
    """Who is in control, and who has asked for it."""

    ASKS = "{person} asks {other} for control"
    KEEPS = "{person} keeps control, {other} has asked"
    TAKES = "{person} takes control"
    TAKES_OVER = "{person} takes control over from {other}"
    HANDS_OVER = "{person} hands control over to {other}"
    GIVES_BACK = "{person} gives control back"
    GONE = "{person} left: nobody is in control"


class RowStop(Text, subject="row-stop"):
    """Why the plans of a row that were to follow are not sent."""

    ENDED = "the row has ended after {count} of {total} {total:plan|plans}: {why}"
    LOOK_AT_STATION = "check whether a part is on station {station}; take it away"
    STOPPED_BY = "stopped by {person}"
    NO_REPORT = "the robot link has not reported on each part"
    NOT_PICKED = "the {arm} arm has not reported its part as picked"
    NOT_PICKED_SINCE = "the {arm} arm has not reported its part as picked: {why}"
    PERSON_SAYS = "{person} reports: {part} was not picked"
    TWO_PARTS = "{person} reports: a second part came with {part}"
    NOT_APPROVED = "the next plan is not approved"
    NO_JOINTS = "the controller does not report where the robot stands"


class NextText(Text, subject="next"):
    """What has to be done before a command is in order."""

    SCAN = "take a scan first"
    FIND = "find the parts first"
    PLAN = "make a plan first"
    APPROVE = "have the plan approved first"
    SEND = "send the plan, or make a new one"
    WAIT = "the plan is on its way to the robot; stop it or wait for the end"
    SCAN_AGAIN = "the cycle is done and the bin has changed; take a new scan first"
    ACKNOWLEDGE = "acknowledge the fault first"
    NOTHING_SENDING = "nothing is being sent"
    NOTHING_SENT = "nothing was sent"
    NO_FAULT = "there is no fault"


class ClearanceText(Text, subject="clearance"):
    """How near a plan comes to anything."""

    FREE = "minimum clearance {free:mm} (free motion)"
    BOTH = "minimum clearance {free:mm} (free motion), {linear:mm} (linear motion)"
    SPEEDS = "no point is faster than {point:mm/s}, the TCP than {tcp:mm/s}"
    ENERGY = "kinetic energy in a contact at most {energy} J"


class LeftText(Text, subject="left"):
    """Why a part stays in the bin of a simulation."""

    NOT_FOUND = "not found"
    STOPPED = "stopped"
    WORKS_BUT = "a grasp of it works, but {why}"
    WAS_STOPPED = "the simulation stopped after {count} failed picks in a row"
    NO_PLAN = "there is no plan: {verdict}"
    WAS_NOT_FOUND = "it was not found"
    AS_SCANNED = "not as the last scan shows it and its neighbours: {verdict}"
    FALSE_PART = "a false detection"
    NONE_WORKS = "none of {count} candidates works ({reasons}); the furthest: {verdict}"
    COUNTED = "{count} {reason}"
    PICK_FAILED = "a pick of it has failed"

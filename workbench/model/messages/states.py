"""What state lines say, and why parts stay in the bin of a simulation."""

from workbench.model.messages.message import Message, Text


class TaskText(Text, subject="task"):
    """The tasks of the worker, by their names."""

    SCAN = "the scan"
    LOCALIZE = "the search for parts"
    PLAN = "the planning"
    SIGHT = "the scan of the plate"
    IMPORT = "the new part"
    TOOL = "the new tool"
    EMPTYING = "the emptying"
    OTHER = "the task {name}"


def task_message(name: str) -> Message:
    """A task of the worker for people."""
    known = {text.name.lower(): text for text in TaskText if text is not TaskText.OTHER}
    return known[name]() if name in known else TaskText.OTHER(name=name)


class StateText(Text, subject="state"):
    """What happened last."""

    TASK_FAILED = "{task} failed: {why}"
    TASK_CANCELLED = "{task} was cancelled"
    CANCELLED_BY = "{task} was cancelled by {person}"
    FOUND = "{count} {count:part|parts} found"
    NOTHING_FOUND = "no part found"
    POSES_REFUSED = "poses from outside cannot be used: {problem}"
    CELL_REFUSED = "the cell file cannot be used, the cell stays as it was: {problem}"
    ENDS_HERE = "going on ends here"
    ENDS_AFTER_TASK = "after this task nothing goes on by itself"
    NEXT_CYCLE = "for the next cycle: {message}"
    NO_PLAN = "no plan: {verdict}"
    NOT_PROVEN = "a plan was found, but its proof does not hold: {violation}"
    NO_PROOF = "a plan was found, but it has no proof"
    PLAN_READY = "plan ready: {strategy}, {cycle:s}, minimum clearance {clearance:mm}"
    NOTE = "{person} notes: {text}"
    MORE_PLANS = "{count} more {count:plan|plans} in a row after it"


class ClearanceText(Text, subject="clearance"):
    """How near a plan comes to anything."""

    FREE = "minimum clearance {free:mm} (free motion)"
    BOTH = "minimum clearance {free:mm} (free motion), {linear:mm} (linear motion)"


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

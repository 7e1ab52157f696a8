"""What state lines say, and why parts stay in the bin of a simulation."""

from workbench.model.messages.message import Text


class StateText(Text, subject="state"):
    """What happened last."""

    NEXT_CYCLE = "for the next cycle: {message}"
    NO_PLAN = "no plan: {verdict}"
    NOT_PROVEN = "a plan was found, but its proof does not hold: {violation}"
    NO_PROOF = "a plan was found, but it has no proof"
    PLAN_READY = "plan ready: {strategy}, {cycle:s}, minimum clearance {clearance:mm}"
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

"""What plans say: words for legs and strategies, remarks of the planner, and why a row ends."""

from workbench.model.messages.message import Message, Text, plain


class LegText(Text, subject="leg"):
    """The legs of an arm, by their names."""

    REACH = "reach"
    APPROACH = "approach"
    EXTRACT = "extract"
    RETURN = "return"
    PLACE = "place"
    HOME = "home"
    VIEW = "view"
    STIR = "stir"
    STOW = "stow"
    RETRACT = "retract"
    CROSS = "cross"
    DOCK = "dock"
    UNDOCK = "undock"
    LIFT = "lift"
    CARRY = "carry"


class StepText(Text, subject="step"):
    """What a step of a plan moves."""

    RUN = "{arm} {leg}"
    RUNS = "{runs:and}"


class CycleText(Text, subject="cycle"):
    """How long a plan takes."""

    TIME = "{seconds:s}"
    BOUND = "{seconds:s}, {times:1} × the theoretical minimum"


class StrategyText(Text, subject="strategy"):
    """Which arms work."""

    AUTO = "auto"
    BOTH = "both"
    SINGLE = "single"
    ALTERNATED = "alternated"
    COORDINATED = "coordinated"
    ONE_ARM = "{arm} arm only"


class OrderText(Text, subject="order"):
    """Which part is taken first, by the names of `OrderName`."""

    TRAVEL = "travel"
    HIGHEST = "highest"
    SCORE = "score"
    NEAREST = "nearest"
    WALLS = "walls"
    THESIS = "thesis"


class ArmText(Text, subject="arm"):
    """Names of arms that people read in their language; others stay as the cell has them."""

    LEFT = "left"
    RIGHT = "right"


class GuaranteeText(Text, subject="guarantee"):
    """Under which condition the arms stay apart."""

    ONE_AT_A_TIME = "one-at-a-time"
    TIME_INDEPENDENT = "time-independent"
    SYNCHRONISED = "synchronised"


class MotionText(Text, subject="motion"):
    """How a leg moves."""

    JOINT = "free"
    LINEAR = "linear"


class PlanNote(Text, subject="plan"):
    """Remarks of the planner on its plan."""

    NO_OTHER_ARM = "one arm: no grasp of another part works with the other arm"
    NEARER = "parts {distance:mm0} apart, below the threshold of {threshold:mm0}"
    FARTHER = "parts {distance:mm0} apart, threshold {threshold:mm0}"
    NOT_AT_ONCE = "the arms cannot work at once: {verdict}"
    FOUND_GRIP = "a search found the grasp for {parts:and}; no library has it"
    QUICKER_REFUSED = "the proof refuses a quicker plan: {violation}"
    GOES_UNSEEN = "collision possible with parts not found where the scan shows nothing"
    MATES_SELDOM = "{chance:%} of picks mate {part} with {base}, {share:%} are asked for"
    PUT_ON_STATION = "regrasp: put on station {station}, picked again from there"
    TAKEN_FROM_STATION = "regrasp: picked from station {station}"


class RowEnd(Text, subject="row"):
    """Why no further plan follows in a row."""

    NO_PART = "no part is left"
    NO_PLAN = "no plan after that: {verdict}"
    REFUSED = "the proof of the next plan does not hold: {violation}"
    MOST = "a row has at most {count} plans"
    KIT_COMPLETE = "the kit is complete"


def strategy_message(strategy: str) -> Message:
    """A strategy, or what a request can ask for instead of one, for people."""
    known = StrategyText.__members__.get(strategy.upper())
    if known is None or known is StrategyText.ONE_ARM:
        return StrategyText.ONE_ARM(arm=str(strategy))
    return known()


def guarantee_message(guarantee: str) -> Message:
    """A guarantee for people."""
    return GuaranteeText[guarantee.upper().replace("-", "_")]()


def leg_message(leg: str) -> Message:
    """The name of a leg for people; one that no plan has is shown as it is."""
    known = LegText.__members__.get(leg.upper())
    return plain(leg) if known is None else known()


def motion_message(motion: str) -> Message:
    """How a leg moves, for people."""
    return MotionText[motion.upper()]()


def cycle_words(seconds: float, bound: float) -> Message:
    """How long a plan takes [s], for people, and how that compares with its bound, where known."""
    if bound <= 0:
        return CycleText.TIME(seconds=seconds)
    return CycleText.BOUND(seconds=seconds, times=seconds / bound)

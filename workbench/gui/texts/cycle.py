"""Texts of the tab Cycle, without its approval."""

from workbench.model.messages.message import Text


class StatusText(Text, subject="page-status"):
    """The line above all tabs: what goes on, and what has changed."""

    FAULT = "Fault: {fault}"
    PLAN_READY = "Plan ready: {plan}"
    CHANGED_SINCE = "Changed since {since}. Nothing is sent before an engineer acknowledges it:"
    UNRECORDED_SENDING = "The sending has ended without a record:"
    UNRECORDED_TASK = "The task has ended without a record:"
    THEN = "then: {message}"
    PLACED = "{count} of {total} placed"


class CyclePageText(Text, subject="page-cycle"):
    """Results of the steps, the threshold, the row and the sending."""

    SCANNED = "{points:n} points ({source})"
    SCANNED_AT = "{points:n} points ({source}), {at}"
    FOUND = "{parts}, score {scores}"
    PLACED = "no scan: {count} {count:part|parts} placed by hand or from outside"
    PLAN = "{strategy}, {count} {count:part|parts}, {time:s}"
    PLAN_OF_ROW = "{number} of {count}: {plan}"
    UNKNOWN_CLEAR = "{strategy}, clear of {count} unknown {count:obstacle|obstacles}"
    CHANGES_TOOL = "The {arm} arm puts down its tool and takes {tool}, clear of the whole bin"
    STIRS = "The {arm} arm stirs the parts at up to {speed:mm/s}, clear of everything else"
    DROPS_BACK = (
        "The {arm} arm drops back what it holds ({held}), clear of the whole bin on its way there"
    )
    TO_HOME = "The {arm} arm takes the scanner home, clear of the whole bin"
    TO_VIEW = "The {arm} arm takes the scanner to view {view}, clear of the whole bin"
    LEFT = (
        "{count} {count:part|parts} left; most frequent reason: {reason} ({number}, {arms:and} arm)"
    )
    LEFT_FOR_LATER = "{count} {count:part|parts} left for a later plan"
    LEFT_UNTRIED = "{count} {count:part|parts} left: no grasp was tried"
    PROOF_FAILS = "The proof does not hold: {violation}"
    NO_PROOF = "The plan has no proof."
    FORECAST = "Of {piles} simulated pairs at {distance:mm0}: {facts}"
    FORECAST_OTHER_CELL = (
        "Study of an earlier cell, {piles} simulated pairs at {distance:mm0}: {facts}"
    )
    FORECAST_APART = "{share:%} far enough apart"
    FORECAST_PLANNED = "{share:%} planned"
    FORECAST_TIME = "in {time:ms}"
    FORECAST_RATE = "{count} parts per hour"
    COORDINATED = "Both arms at once, if quicker: {count} of {total} {total:pair|pairs} far apart"
    ALTERNATED = "One arm after the other: parts {distance:mm0} apart at most"
    PICKS = "{count} {count:pick|picks} in a row"
    OVER_STATION = "two of them for a part that goes over a station"
    LEFT_OUT = "{count} left out"
    TAKES = "{part} {arm}"
    TAKES_TO_STATION = "{part} {arm}, to station {station}"
    DIGESTS = "plan {plan}, proof {proof}"
    EMPTY_BINS = "Nothing left to take: {bins}."
    CORRECT_PART = "Correct {part}"
    BIN_IS_NEW = "Bin {name} is new"
    MESSAGES_SENT = "{count} of {total} messages sent"
    STEP = "step {number} of {total}"
    STEP_DONE = "the only step is done"
    STEPS_DONE = "all {total} steps done"
    ENDED_IN_STEP = "ended in step {number} of {total}"
    SENT_OF_PLAN = "{sent} (plan {number})"
    BEFORE_STEP = "Before step 1 of {total}"
    RUN_STEP = "Run step {number} of {total}: {legs}"
    STEP_RUNS = "Step {number} of {total} runs: {legs}"
    PARTS_STAY = "Simulation: the next scan shows the {count} {count:part|parts} left in the bin"
    RUNS_MEANWHILE = "During the motion runs {task}."
    PICKED = "{arm} picked"
    FAILED = "{arm} failed"
    DROPPED = "{arm} dropped"
    DOUBLE = "{arm} double"
    PART_PICKED = "{part} picked"
    PART_FAILED = "{part} failed"
    PART_DROPPED = "{part} dropped"
    PART_DOUBLE = "{part} double"
    REPORTED_BY = "reported by {person}"
    REPORTED_BY_WHY = "reported by {person}: {why}"


class LinkPageText(Text, subject="page-link"):
    """The robot link: its protocol, its last message, and the parts."""

    VERSION = "{link} (protocol {version})"
    POSES = (
        "Vision only: the robot gets poses and moves by its own program. Nothing of its motion is "
        "proven."
    )
    UNAPPROVED = "{person} has switched approval off: poses go out that nobody has approved."
    STEP = "{phase}, step {number} of {total}"
    AGO = "{age:s} ago"
    COUNT = "{count} of {total}"
    SENT_AT = "sent at {at}"
    RECEIVED_AT = "received at {at}"
    ANSWERED = "{sent}, answered by {answer}"
    PICKED = "{part} picked"
    FAILED = "{part} failed: {why}"
    UNKNOWN = "{part} unknown: {why}"
    REPORTED_LAST = "The controller reported these last at {at}."
    ARM_UNITS = "{arm} [{units}]"

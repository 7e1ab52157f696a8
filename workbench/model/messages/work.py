"""What the worker process, the robot link and the session report of their work."""

from workbench.model.messages.message import Message, Text, plain


class JobText(Text, subject="job"):
    """How tasks of the worker process fail, and why a command is not carried out or recorded."""

    WRONG_RESULT = "the result was a {kind}"
    CANCELLED = "{task} was cancelled"
    INTERNAL = "internal error, see the log: {kind}: {error}"
    NO_START = "the worker process cannot be started: {error}"
    NO_WORKER = "there is no worker process"
    NOT_READY = "the worker process cannot start: {error}"
    UNREADABLE = "the answer of the worker process cannot be read: {kind}: {error}"
    ENDED = "the worker process ended ({how}) during {task}"
    ENDS_AT_START = "the worker process ends at its start ({how})"
    UNKNOWN = "there is no task {name}; there are {known}"
    CLOSING = "the workbench is closing"
    INTERRUPTED = "the workbench ended before the task was done"
    STOP_UNRECORDED = "the stop is carried out, but it cannot be recorded: {error}"
    UNRECORDED = "the journal cannot be written, so nothing was done: {error}"
    SAVED = "saved: {things}"
    THE_CELL = "the cell"
    CELL_FILE = "{file} ({changes})"
    VIEWS_BY_JOINTS = "views by joints, so that the arm still scans from the same postures"
    GRASPS = "the grasps of {part} as version {version}"
    SIZE = "the size of {part}"
    NO_CELL_FILE = "this session has no cell file"
    FILES_CHANGED = (
        "the files of the cell were changed since they were read, so nothing is written; look at "
        "the cell as they have it, and save again"
    )


class LinkText(Text, subject="link"):
    """How a sending ends, and what the robot is reported to do."""

    INTERRUPTED = "the workbench ended while sending; check how far the robot has moved"
    NOTHING_SENT = "stopped before anything of this plan was sent"
    APPROVAL_USED = "this approval has been used; have the plan approved again"
    NO_REPORT = "{link} had not reported on it at the end"
    WENT_WELL = "the sending ended as planned"
    ENDED_BUT = "{how}; {problem}"
    NOT_SEEN_STANDING = "nobody has reported that the robot stands: use the emergency stop"
    STANDS_AFTER = "the robot was reported to stand after {took:ms}"
    PHASE = "{phase}, step {step} of {steps}"
    CONTROLLER_SAYS = "{fault}; the controller reports: {report}"
    REPORTS_FAULT = "the controller reports a fault: {fault}"
    OTHER_ARM = "the controller moves arm {moving}, the order was for arm {ordered}"
    FAULT = "fault: {fault}"
    MOVES = "moves arm {arm}"
    STANDS = "stands"


class AskText(Text, subject="asked"):
    """Why the robot program that asks the pick server gets nothing more of a plan."""

    NOBODY = "no robot program asked for the plan within {seconds:s}"
    SILENCE = "the robot program was silent for {seconds:s} at {where}"
    NO_PROGRESS = "the robot program made no progress for {seconds:s} at {where}"
    ELSEWHERE = "the robot stands elsewhere at {where}: {joint} away"
    NO_JOINTS = "what the robot program reports at {where} cannot be: {problem}"
    WRONG_JOB = "the robot program asked for {job} at {where}, which does not follow"
    TWICE = "the robot program used the number of a request twice at {where}"
    BEGAN_ANEW = "the robot program began anew at {where}"
    STOPPED = "the robot program stopped at {where}: {why}"
    NOT_PROVEN = "the plan cannot be written as lines: {problem}"
    NO_ADDRESS = "cannot listen at {address}: {problem}"
    ABSENT = "no robot program is connected"
    BEFORE = "the beginning"
    LEG = "leg {leg} of {legs}"
    POSE = "pose {pose} of {poses}"


class StopText(Text, subject="stopped"):
    """How the controller answers a stop."""

    AT = "sending was stopped at {where}; {how}"
    BEFORE = "sending was stopped before {where}"
    NOT_SPOKEN = "sending was stopped before the controller was spoken to"
    ACKNOWLEDGED = "the controller acknowledged the stop after {took:ms}"
    STANDS = "the controller reported that it stands after {took:ms}"
    NOT_ACKNOWLEDGED = "the controller did not acknowledge the stop: use the emergency stop"
    NOT_STANDING = "the controller did not report that it stands: use the emergency stop"
    SINCE = "{what} ({why})"


class LinkPhase(Text, subject="link-phase"):
    """The states of a controller on the link."""

    CONNECTING = "connecting"
    GREETED = "greeted"
    READY = "ready"
    LOADING = "loading"
    LOADED = "loaded"
    RUNNING = "running"
    WAITING = "waiting"
    DONE = "done"
    FAULT = "fault"
    STOPPED = "stopped"
    CLOSED = "closed"


def phase_message(phase: str) -> Message:
    """A state of a link for people; one that only its maker knows is shown as it is."""
    known = LinkPhase.__members__.get(phase.upper())
    return plain(phase) if known is None else known()


class CaseRefusal(Text, subject="case"):
    """Why what was found is not stored as a case."""

    OTHER_ROLE = "storing a case is for {role}; you are {yours}"
    SENDING = "storing a case has to wait until the sending has ended"
    NOTHING_FOUND = "find the parts first: a case holds what was found and what is there"
    STORED = "this was stored a moment ago, as {name}"
    MOST = "this session has {most} cases, the most that are allowed; move some out of {folder}"


class ProgressText(Text, subject="progress"):
    """What a task is doing."""

    GETTING_READY = "getting ready, once, about a minute"
    SCANNER_LOOKS = "the scanner takes the picture"
    BALLS = "searching for the balls"
    OBSTACLES = "searching for obstacles that no model explains"
    PARTS_FALL = "parts fall into the bin"
    PREPARE = "preparing {part} and mapping the scan"
    VOTE = "voting"
    GLANCE = "searching coarsely"
    LOOK_CLOSELY = "checking closely"
    CANDIDATES = "candidate {number} of {count}"
    HAND_CHECKS = "checking hand {number} of {count}"
    MOTION = "searching for the motion"
    PROOF = "proving the plan"
    PLAN_OF_ROW = "plan {number} of {count}: {step}"
    OF_STRATEGY = "{strategy}: {step}"
    STATIONS = "planning over a station"
    STATION_POSES = "pose {number} of {count} on a station"
    STATION_PATHS = "path to a station {number}"
    FALLING = "the parts fall"
    TAKEN = "{taken} of {count} taken"
    CHANGES = "preparing the changes"
    GRIPS = "testing grasps"
    FILLED = "{taken} of {parts} parts taken in simulated piles"
    ADDED = "{added} of {looked} parts taken by new grasps"
    DIRECTIONS = "{done} of {count} directions"
    WHAT_TO_ADD = "searching for grasps to add"
    WHAT_TAKES = "searching for what takes {part}"
    READING = "reading the file"
    READING_BODY = "reading the body"
    CONVEX_PIECES = "making convex pieces"
    JOINING = "joining triangles"
    MENDING = "repairing the surface"
    SIMPLIFYING = "simplifying {count} triangles"
    EXCESS = "measuring the convex pieces"
    SYMMETRY = "searching for the symmetry"
    FINGERS_OR_CUP = "making fingers or cup"
    WAITS_FOR_FILE = "waiting for a file in {folder}"
    WAITS_FOR_IMAGE = "waiting for an image of {scanner}"
    ASKS = "asking {address}"
    CAME = "{size} MB have come"
    MEETS_ROBOT = "checking for collisions with the robot"


class CancelText(Text, subject="cancelled"):
    """What a person has cancelled."""

    PLATE_SCAN = "the scan of the plate was cancelled"
    SCAN = "the scan was cancelled"
    SEARCH = "the search for parts was cancelled"
    PLANNING = "planning was cancelled"
    EMPTYING = "the emptying was cancelled"
    FILLING = "filling the library was cancelled"
    IMPORT = "the import was cancelled"
    TOOL = "the new tool was cancelled"

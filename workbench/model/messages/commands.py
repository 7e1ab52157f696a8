"""What commands, roles, things of a cell and values are called in refusals."""

from workbench.model.messages.message import Text


class CommandText(Text, subject="command"):
    """The commands, by the names of their classes, as sentences have them."""

    TAKE_SCAN = "a scan"
    USE_SCAN = "a scan from a file"
    SIGHT_PLATE = "a scan of the plate"
    USE_OBSERVATIONS = "a change of the calibration poses"
    FIND_PARTS = "the search for parts"
    USE_DETECTIONS = "the use of poses from outside"
    MAKE_PLAN = "planning"
    WANT_THRESHOLD = "another threshold"
    SHORTEN_ROW = "another length of the row"
    WATCH_PLAN = "a preview"
    APPROVE = "an approval"
    SEND_PLAN = "sending"
    NEXT_STEP = "a step"
    STOP = "a stop"
    SENT = "a message sent"
    LINK_ENDED = "the end of sending"
    REPORT_PICK = "the outcome of a pick"
    FORGET_AVOIDED = "the end of avoiding parts"
    ACKNOWLEDGE_FAULT = "the acknowledgement of the fault"
    GO_ON = "the next cycle"
    JOB_ENDED = "the end of a task"
    CANCEL_JOB = "the cancelling of a task"
    CHANGE_CELL = "a change of the cell"
    UNDO_CELL = "an undo"
    REDO_CELL = "a redo"
    SAVE_CELL = "saving the cell"
    CELL_READ = "a new cell file"
    EMPTY_PALLETS = "emptying the pallets"
    EDIT_PART = "a change of grasps"
    DROP_DRAFT = "discarding a draft"
    IMPORT_PART = "a new part"
    ADD_TOOL = "a new tool"
    TRY_EMPTYING = "emptying piles in simulation"
    ASK_FOR_CONTROL = "the request for control"
    TAKE_CONTROL = "taking control"
    GIVE_CONTROL = "handing control over"
    DENY_CONTROL = "keeping control"
    RELEASE_CONTROL = "giving control back"
    STARTED = "a start"
    OPENED = "opening the session again"
    ACKNOWLEDGE_CHANGES = "the acknowledgement of changes"
    WRITE_NOTE = "a note"
    POSES_REFUSED = "a problem with poses"


class RoleText(Text, subject="role"):
    """Roles of people: their names, one person of a role, and all of them."""

    VIEWER = "viewer"
    OPERATOR = "operator"
    ENGINEER = "engineer"
    A_VIEWER = "a viewer"
    AN_OPERATOR = "an operator"
    AN_ENGINEER = "an engineer"
    VIEWERS = "viewers"
    OPERATORS = "operators"
    ENGINEERS = "engineers"


class MannerText(Text, subject="manner"):
    """How a plan is sent."""

    SPEED = "at {share:%} of the planned speed"
    STEPPED = "step by step"
    BOTH = "{speed}, {stepped}"


class NameText(Text, subject="name"):
    """Values and things that refusals name, and the units of values."""

    LEAST_SCORE = "least score"
    SPEED_SHARE = "speed share"
    KIND_OF_CHANGE = "kind of change"
    OF_USUAL = "of the usual"
    OF_JOINT_BEFORE = "of the joint before"
    OF_PLANNED_SPEED = "of the planned speed"
    BIN = "bin"
    SCANNER = "scanner"
    ROBOT = "robot"
    REGION = "region {region}"
    PLACE = "a place of the {arm} arm"
    PART_PLACE = "a place of parts of the {arm} arm"


class StaleText(Text, subject="stale"):
    """Why a plan does not hold any more."""

    PLAN = "plan {plan} is stale: {why}"
    PARTS_SOUGHT = "parts were searched for again"
    PARTS_CHANGED = "the parts were changed"
    NEWER_SCAN = "there is a newer scan"

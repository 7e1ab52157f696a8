"""What commands, roles, things and values are called in refusals, and remarks on edits."""

from workbench.model.messages.message import Text


class CommandText(Text, subject="command"):
    """The commands, by the names of their classes, as sentences have them."""

    TAKE_SCAN = "a scan"
    USE_SCAN = "a scan from a file"
    SIGHT_PLATE = "a scan of the plate"
    USE_OBSERVATIONS = "a change of the calibration poses"
    SCAN_BALLS = "a scan of the balls"
    RECORD_TOUCH = "a touch of a ball"
    LIMIT_CHECKS = "a limit of the checks"
    REMOVE_CHECK = "removing a scan of the balls or a touch"
    FIND_PARTS = "the search for parts"
    USE_DETECTIONS = "the use of poses from outside"
    MAKE_PLAN = "planning"
    PLAN_VIEW = "planning the path to the view"
    PLAN_STIR = "planning to stir the parts"
    PLAN_TOOL_CHANGE = "planning to change the tool"
    PLAN_DROP_BACK = "planning to drop back what the hand holds"
    STATE_TOOL = "the statement of the tool that an arm carries"
    WANT_THRESHOLD = "another threshold"
    SHORTEN_ROW = "another length of the row"
    WATCH_PLAN = "a preview"
    APPROVE = "an approval"
    SWITCH_APPROVAL = "switching approval off or on"
    RELEASE_POSES = "the release of poses"
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
    CHOOSE_RECIPE = "the choice of a recipe"
    CHOOSE_BIN = "the choice of a bin"
    CHOOSE_VIEW = "the choice of a view"
    NEW_BIN = "a new bin"
    NEW_KIT = "a new kit"
    CHANGE_CELL = "a change of the cell"
    UNDO_CELL = "an undo"
    REDO_CELL = "a redo"
    SAVE_CELL = "saving the cell"
    CELL_READ = "a new cell file"
    CONFIRM_HANDS_EMPTY = "confirming that hands are empty"
    EMPTY_PALLETS = "emptying the pallets"
    EDIT_PART = "a change of grasps"
    DROP_DRAFT = "discarding a draft"
    IMPORT_PART = "a new part"
    ADD_TOOL = "a new tool"
    CORRECT_PART = "the correction of a part"
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


class EditText(Text, subject="edit"):
    """Remarks on what was done to cell, detections and calibration."""

    CELL_UNDONE = "undone: {change}"
    CELL_REDONE = "made again: {change}"
    CELL_AS_FILE = "the cell is as in its file"
    CELL_SAVED = "the cell is saved"
    CELL_FILE_CHANGED = "the cell file was changed and is read again"
    TOOL = "the {arm} arm carries {tool}"
    MOVED = "the {thing} is moved"
    HOME = "the {arm} arm has another home"
    PLACE_ADDED = "the {arm} arm has another place"
    BIN_MOVED = "the bin was moved by {shift:mm} to where the scan shows it"
    PART_SCALED = "{part} is {scale} times as large as its CAD file"
    PART_GROWN = "the surface of {part} lies {offset:mm2} outside of its CAD file"
    SCANNER_MOVED = "{by} moved the scanner to where recorded scans show it"
    SCANNER_FITTED = "the scanner is fitted to {file}"
    BIN_FITTED = "the scanner is fitted to {file}, and the bin is {size} mm large"
    CALIBRATED = "{by} calibrated the scanner with {used} {used:pose|poses}"
    POSE_USED = "{pose} is used again"
    POSE_LEFT_OUT = "{pose} is left out"
    POSE_REMOVED = "{pose} is removed"
    POSES_TAKEN = "{count} {count:pose|poses} taken from outside"
    POSES_FROM = "{count} {count:pose|poses} taken from {file}"
    SEARCH_TAKEN = "the detections of search {search} are taken"
    PARTS_UNDONE = "the last change of the parts is undone"
    PART_ADDED = 'a part "{part}" was placed by hand'
    PART_CORRECTED = "{found} was corrected by hand"
    PART_VETOED = "{found} ({part}) was vetoed"


class GraspEditText(Text, subject="grasp-edit"):
    """Remarks on what was done to the grasps of a part."""

    CHANGED = "the grasps of {part} are changed"
    SYMMETRY = "the symmetry of {part} is set"
    PAIR = 'grasp "{first}" goes with "{second}"'
    NO_PAIRS = "the pairs of grasps are removed"
    VERSION = "the grasps are those of version {version}"
    DRAFT = "the draft of an earlier session is taken"
    LEARNED = "new grasps for parts of {part} that were left"
    FILLED = "{count} {count:family|families} of grasps fill the library"
    SUGGESTED = "{count} suggested grasps are added"
    ADDED = 'grasp "{grasp}" is added'
    FOUND = "grasps of a search are added: {grasps:and}"
    ADDED_FOR_COVERAGE = 'grasp "{grasp}" is added where no grasp worked'
    EDITED = 'grasp "{grasp}" is edited'
    DELETED = 'grasp "{grasp}" is deleted'
    DUPLICATED = 'grasp "{grasp}" is duplicated'
    MIRRORED = 'grasp "{grasp}" is mirrored across {plane}'
    REPEATED = 'grasp "{grasp}" is repeated {count} times'
    SPLIT = 'grasp "{grasp}" is now {count} single grasps'
    SINGLE = 'grasp "{grasp}" is now a single grasp'
    COPY_OF_LOST = 'grasp "{copy}" is added: somebody else changed "{grasp}" first'
    OFFSET = 'grasp "{grasp}" is put at an offset from "{other}"'
    ON_SURFACE = 'grasp "{grasp}" is put on the surface'
    MOVED_BY_NUMBERS = 'grasp "{grasp}" is moved by numbers'
    MOVED_BY_GIZMO = 'grasp "{grasp}" is moved by the gizmo'
    NUDGED = 'grasp "{grasp}" is moved by a key'
    SNAPPED = 'grasp "{grasp}" is put on the nearest surface'


class StaleText(Text, subject="stale"):
    """Why a plan does not hold any more."""

    PLAN = "plan {plan} is stale: {why}"
    PARTS_SOUGHT = "parts were searched for again"
    PARTS_CHANGED = "the parts were changed"
    NEWER_SCAN = "there is a newer scan"

"""Why a robot controller or a scanner cannot be used, or a sending ends early."""

from workbench.model.messages.message import Text


class DeviceText(Text, subject="device"):
    """What goes wrong between the workbench and a robot controller, and where in a program."""

    PROTOCOL = "protocol error: {detail}"
    NO_ANSWER = "no controller answers at {address} ({reason})"
    NO_STATE = "no controller reports its state at {address} ({reason})"
    UNKNOWN_HOST = "the controller {host} is not known ({reason})"
    PORT = "{port}: {reason}"
    SILENT = "the controller was silent for {seconds:s} at {where}"
    NOTHING_NEW = "the controller has reported nothing new for {seconds:s}"
    BROKEN = "the link broke at {where}: {reason}"
    CLOSED = "the controller closed the link at {where}"
    CLOSED_OLD = "the controller closed the link at {where}; perhaps it speaks an older protocol"
    NOT_ACKNOWLEDGED = "the controller did not acknowledge {frame} within {seconds:s}, at {where}"
    REFUSES = "the controller refuses {where}: {why}"
    FAULT = "the controller reports a fault at {where}: {fault}"
    STATE_BROKEN = "the state report broke off: {reason}"
    STATE_CLOSED = "the controller closed its state report"

    MESSAGE = "message {number} of {total}"
    STEP = "step {number} of {total}"
    STEP_WAITS = "step {number} of {total}, which had not begun"
    LEG = "leg {number} of {total}"
    LAST_MOTION = "the end of the last motion"
    PLAN_START = "the start of the plan"
    PLAN_END = "the end of the plan"
    LEG_START = "the start of leg {leg}"
    LEG_END = "the end of leg {leg}"
    PLAN = "plan"
    CELL = "cell"
    PLAN_CELL = "cell of the plan"
    SCAN = "scan"

    UNSENDABLE = "the robot link {link} cannot send this plan: {detail}"
    ONE_ARM = (
        "the robot link {link} moves one arm at a time, this plan moves both; make an alternated "
        "plan to send it, or use a robot link that moves two"
    )
    FINER_STEPS = (
        "the plan was made for finer steps than the robot link {link} can send, so what is sent "
        "would not be what was proven; make a new plan"
    )
    NO_PATHS = "the robot link {link} sends poses alone: no path without a part goes out"
    NO_TIMES = "the robot link {link} does not send times: no path that has to be slow goes out"
    NO_MAPPING = "the robot link {link} does not know the axis_coupling of arm {arm}"
    NO_OUTPUTS = "the robot link {link} cannot switch the output of TCP {tcp}; leave `output` out"
    NO_SHARE = "the robot link {link} cannot send a plan at a share of its speed"
    NO_STEPS = "the robot link {link} cannot send a plan step by step"
    TOO_SLOW = (
        "at {share:%} of its speed the plan takes {longest:s} from one waypoint to the next; the "
        "robot link {link} allows {most:s}"
    )
    OTHER_APPROVAL = "the approval is for another {what} ({approved}, here {present})"
    NOBODY_APPROVED = (
        "nobody has approved this plan; the robot link {link} sends paths, which somebody has to "
        "approve"
    )
    APPROVAL_EARLY = "the approval begins in {seconds:s}: a clock has been set back"
    APPROVAL_OVER = "the approval ran out {seconds:s} ago"

    OFF_TARGET = "{joint} stands {off:deg1} from {where}"
    NOT_FOLLOWING = "{name} does not follow in {where}: {off:deg1} from its reference"
    NOT_AT_REST = "{arm} does not come to rest at {where}"
    NOT_DONE = "the controller has not carried out: {arm} {order}"
    RUN_BEFORE = "the controller has begun this plan already; nothing runs twice"
    TWICE = "the program came to the controller twice, at {where}; the second one has not begun"
    LOCAL_CONTROL = "the robot is in local control; choose remote control on its panel"
    CANNOT_MOVE = "the robot cannot move: {fault}"
    OTHER_RUNS = "the controller runs another program, or holds one that is paused"
    NOT_TAKEN = "the controller did not take the program"
    NOT_BEGUN = "the controller did not begin the program; see its log"
    NOT_ENDED = "the controller does not end the program after its last leg"
    ENDED_EARLY = "the controller ended the program at {where}"
    CLIENT_ENDED = "the client of the controller has ended"
    CLIENT = "the client of the controller reports: {problem}"
    NO_REPORTS = "no controller reports {arm} at its UDP port"
    MODULE_SILENT = "{arm}: the program on the controller does not answer; is it loaded?"
    LATE = "a report came {late:ms} late in {where}"
    LOST = "reports were lost: {where}"
    LIBRARY_VERSION = "the library {library} has another version: {reason}"
    LIBRARY = "the library {library} is not installed: {command}"


class ScannerText(Text, subject="scanner"):
    """Why a scanner gives no scan."""

    PROBLEM = "scanner {name}: {problem}"
    VIEW = "view {name}: {problem}"
    NO_FOLDER = "there is no folder {folder}"
    NO_FILE = "no new PLY or PCD file came into {folder} within {patience:s} (patience_s)"
    NO_IMAGE = "no image came within {patience:s} (patience_s)"
    NO_RECORDING = "there is no recording {file} (file)"
    RECORDING_ENDS = "the recording ends after {count} images; {skipped} are skipped"
    NOTHING_MEASURED = "{image} has no pixel with a measurement"
    OUT_OF_RANGE = (
        "{image} is {nearest:mm0} to {farthest:mm0} away, and the scanner measures from {near:mm0} "
        "to {far:mm0} (near_mm, far_mm): {doubt}"
    )
    IS_IT_THIS = "is it this scanner?"
    IS_SCALE_RIGHT = "is the scale of {scale:mm2} a count right (scale_mm)?"
    MOST_POINTS = "{count:n} points in all, at most {most:n} are taken"
    NOT_CALIBRATED = "its pose was never calibrated"
    CALIBRATION_OLD = "calibrated {days} days ago; {allowed} are allowed (calibration_days)"
    NO_CAMERA = "no camera answers (found: {found})"
    NO_SUCH_CAMERA = "no camera with the serial number {serial} answers (found: {found})"
    CAMERAS = "{count} cameras answer ({found}); choose one by serial or address"
    OTHER_CAMERA = "the camera that answers has the serial number {found}, not {serial}"
    GONE = "the camera has gone: {reason}"
    IMAGE = "image {number} cannot be used: {detail}"
    SETTING = "setting of the camera: {detail}"
    NO_FEATURE = "the camera has no {feature}; give {key} in [scanner.options]"
    NO_DEPTH = "it has no depth images"
    NO_DEPTH_SIZE = "it has no depth images of {columns} x {rows} pixels"

    TOO_SLOW = "it is too slow: {size} MB and no end within {patience:s} (patience_s)"
    TOO_LARGE = "it sends more than a scan can hold"
    OTHER_CERTIFICATE = (
        "its certificate is {found}, not that of certificate_sha256; nothing was asked"
    )
    CERTIFICATE = (
        "its certificate is not trusted: {reason}; ca_file names the authority that signed it, "
        "certificate_sha256 this certificate alone"
    )
    NO_ADDRESS = "this is no address of a page"
    LOGIN_WANTED = "it asks for a login ({status}): give login in [scanner.options]"
    LOGIN_REFUSED = "it refuses the login {login} ({status})"
    REDIRECTS = "it redirects to {host} ({status}), which is not followed: give that address"
    NO_CLOUD = "it sends no file: {status}"
    SECRET = "the secret of the login cannot be read: {detail}"

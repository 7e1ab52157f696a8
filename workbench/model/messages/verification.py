"""Whether a calibrated scanner measures truly, and agrees with the robot."""

from workbench.model.messages.message import Text


class VerifyText(Text, subject="verify"):
    """Trueness by balls of known distances, and the touch test."""

    LENGTHS = "one length of a ball bar or three of a plate are needed, not {count}"
    BAR_LENGTH = "the length of a ball bar is more than the balls' diameter, and up to {longest} m"
    CENTRES = "{scan}: {count} centres of balls are needed"
    NOT_SEEN = (
        "{scan}: the balls are not all visible: {found} of {ball} mm are found, {count} at the "
        "stated distances are needed"
    )
    NO_SCAN = "no scan of the balls yet"
    LIMIT = "a limit is a length above 0 and below 1 m"
    TRUE = "lengths are true: {off:mm2} off at most, limit {limit:mm2}"
    NOT_TRUE = "lengths are not true: {off:mm2} off in {scan}, limit {limit:mm2}"
    SCALED = (
        "lengths are within the limit ({off:mm2} of {limit:mm2}), but all are too long or too "
        "short: the scanner's scale is wrong"
    )
    FEW_SCANS = "{true}; scan the balls in {advised} places or more"
    NO_TCP = "the tool of the {arm} arm has no TCP: it lies in the flange; measure and enter it"
    SEAT = "the inner diameter of the tip is 0 or more, and less than that of the ball, {ball} mm"
    FAR_TOUCH = (
        "the tip is {away:mm} from ball {ball} of {scan}, the nearest: are arm, joints and scan "
        "those of this touch?"
    )
    OTHER_CELL = "{name} is of another robot or scanner: remove it"
    SAME_TOUCH = "these joints are those of {touch} already: bring the tip to another ball"
    NO_SUCH_SCAN = "there is no scan {scan} of the balls: scan them first"
    NO_SUCH = "there is no {name} among scans of the balls and touches"
    MOST_SCANS = "up to {most} scans and {most} touches are taken; remove one first"
    FEW_TOUCHES = "a touch test needs {fewest} touches; there are {count}"
    ON_LINE = (
        "the touched balls lie on one line, so a turn about it stays unseen: touch one beside it"
    )
    NOT_PREDICTED = (
        "no calibration predicts an error: calibrate the scanner, or state a limit for the offsets"
    )
    AGREES = "scanner and robot agree: {off:mm2} at most, predicted {bound:mm2} (95%)"
    AGREES_LIMIT = "scanner and robot agree: {off:mm2} at most, limit {bound:mm2}"
    DIFFERS = (
        "scanner and robot disagree: {off:mm2} in {touch}, predicted {bound:mm2} or less (95%)"
    )
    DIFFERS_LIMIT = "scanner and robot disagree: {off:mm2} in {touch}, limit {bound:mm2}"
    SHIFTED = "{shift:mm2} are a common shift: calibrate again"
    SHIFTED_ALIKE = (
        "{shift:mm2} are a common shift: calibrate again (or the TCP is wrong: the tool was "
        "hardly turned between touches)"
    )
    VARIES = (
        "up to {rest:mm2} change from touch to touch: check TCP, joints and the scanner's scale"
    )
    SCAN_SEEN = "{scan}: balls found ({count} in all)"
    TOUCHED = "{touch}: ball {ball} of {scan}, {away:mm2} from where the scanner has it"
    REMOVED = "{name} is removed"
    TOO_LONG = "the balls do not fit into the bin of this simulation: state shorter lengths"
    NOT_REACHED = "the {arm} arm does not reach this ball with its tool from above"
    SCANNING = "scanning the balls"

"""Texts of the tab Calibration, and of the scanner's calibration elsewhere on the page."""

from workbench.model.messages.message import Text


class CalibrationText(Text, subject="page-calibration"):
    """Calibration of the scanner: its record, poses of the plate, the answer, drift."""

    OLD = "Calibrated {days} {days:day|days} ago; limit: {limit} days."
    CARRIED = (
        "The {arm} arm carries the scanner. Fix the plate where the scanner sees it from its view; "
        "the plate must not move between scans."
    )
    CARRIED_BY_ONLY_ARM = (
        "The arm carries the scanner. Fix the plate where the scanner sees it from its view; "
        "the plate must not move between scans."
    )
    POSE_SIMULATED = "The blue robot shows the pose. In simulation the scan is taken there."
    POSE_REAL = "The blue robot shows the pose. Drive the robot there, then scan the plate."
    NEVER = "The scanner was never calibrated."
    RECORD = "Calibrated {at} by {person}: {count} {count:pose|poses}, {rms:mm2} RMS."
    RECORD_CORNERS = "Error at the corners of the bin: up to {error:mm2} (95%)."
    OFF = "{shift:mm2}, {turn:deg}"
    MOVED = "{shift:mm} and {turn:deg} from its pose in the cell"
    FINDINGS_MOVE = "parts in the bin shift by {shift:mm}"
    AGREEMENT = "{rms:mm2} RMS, {count} used"
    STANDARD_ERRORS = "{position:mm2} and {angle:deg3} (standard errors)"
    PROGRESS = "{count} of {fewest} poses at least; {advised} are better."
    MORE_POSES = "{advised} poses are better than {used}."
    WORST = "worst: {name}, {off}"
    PREDICTED = "{rms} RMS; {worst}"
    SOME_PREDICTED = "not all; {worst}"
    CORNERS = (
        "Error at the corners of the bin: up to {error:mm2} in 95% of such calibrations. "
        "Errors of robot and search add to it."
    )
    NEXT_FROM = "From {pose} on, with the plate held as it is:"
    SCANNER_FROM = "From {pose} on, move the scanner:"
    NEXT_STEP = "{number}. {step}"
    NEXT_GAIN = "Error at the worst corner of the bin: {after:mm2} instead of {before:mm2}."
    OVERLAY = "Points near the robot: {middle}; green to {close:mm0}, amber to {off:mm0}, then red."
    OVERLAY_CELL = (
        "Points near bin, fixtures and robot: {middle}; green to {close:mm0}, amber to {off:mm0}, "
        "then red."
    )
    OVERLAY_NONE = "none"
    OVERLAY_MIDDLE = "median distance {distance:mm}"
    NO_POSE = "The {arm} arm reaches no pose in which the scanner sees the plate."
    NO_POSE_OF_ONLY_ARM = "The arm reaches no pose in which the scanner sees the plate."
    SPACING = "{off:mm2} (limit {limit:mm2})"
    SCALE = "{share} % ± {error} % (99% confidence)"
    SCALE_OPEN = "{share} %; one distance does not show how sure"
    SIZE = "{size:mm2} in diameter on average"
    FORM = "{form:mm2} (band of 95% of the points)"
    SHIFT = "{shift:mm2} (x {x}, y {y}, z {z} mm); up to {bound:mm2} expected"
    REST = "up to {rest:mm2}; up to {bound:mm2} expected"
    READING = "Reading … {done:%}"
    SESSIONS = (
        "{scans} {scans:scan|scans} of {sessions} {sessions:session|sessions} since the "
        "calibration."
    )
    SHIFT_BY = "Shift, by {thing}"
    TURN_BY = "Turn, by {thing}"

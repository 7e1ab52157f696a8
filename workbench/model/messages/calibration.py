"""What scans say of the scanner, its calibration, the bin and the reference plate."""

from workbench.model.messages.message import Text


class PlateText(Text, subject="plate"):
    """Why a reference plate or an observation of it cannot be used."""

    BALLS = "a plate needs balls of 4 to 400 mm in diameter, and three distances"
    DISTANCES = "the distances of the balls must be longer than their diameter, and up to 2 m"
    TOO_ALIKE = (
        "the three distances of the balls must differ by {least:mm0} each, so that the balls can "
        "be distinguished"
    )
    ON_LINE = "the three balls lie nearly on one line; a triangle is needed"
    POINTS = "observation {name}: points of shape (n, 3) are needed"
    CENTRES = "observation {name}: three centres of balls are needed"
    IN_WORLD = (
        'cloud_axes = "world" in [scanner]: the scanner itself puts its points into the frame of '
        "the cell, so it is calibrated there"
    )
    NO_POSE = "no pose was scanned yet; a calibration needs 4, 8 are better"
    MOST_POSES = "{count} poses; up to {most} are taken"
    SAME_POSE = "{pose} is the same as {other}"
    TOO_FEW_POSES = (
        "a calibration needs {fewest} different poses, {advised} are better; there are {count}"
    )
    SINCE_SAME = "{problem} ({same})"
    NOT_TURNED = (
        "the flange has the same orientation in all poses, so the scanner's position stays unknown "
        "in every direction: turn the wrist by 20 degrees or more between the poses"
    )
    ONE_AXIS = (
        "the flange is turned about one axis only, ({axis}) in the world, so the scanner's "
        "position along it stays unknown: tilt the wrist about another axis too, by 20 degrees or "
        "more"
    )
    WITHOUT = "without {poses}, in conflict with the others: {problem}"
    NO_CONSENSUS = (
        "the poses are in conflict: at best half of them fit within {far:mm}. Are the joint values "
        "those of the scans, in the controller's order, and the distances of the balls those of "
        "the plate? Did the plate stay fixed?"
    )
    TOO_UNCERTAIN = (
        "these poses give the scanner's position only to {far:mm} (worst along ({axis}) in the "
        "world) and its direction to {turn:deg}: take more poses, further apart, with the wrist "
        "turned more"
    )
    LEFT_OUT = "left out by a person"
    CONFLICT = "in conflict: {far:mm} and {turn:deg1} off, the others {rms:mm2}"
    OTHER_PLATE = "{pose} is of another plate or arm than {first}; remove one of them"
    OTHER_CARRIER = (
        "{pose} has the joints of the {arm} arm, but the {carrier} arm carries the scanner; "
        "remove it"
    )


class PoseText(Text, subject="pose-step"):
    """How a person brings the plate, or the scanner on an arm, from one pose to the next."""

    PLATE = "the plate"
    SCANNER = "the scanner"
    TURN_LEFT = "turn {thing} by {angle:deg0} counterclockwise, seen from above"
    TURN_RIGHT = "turn {thing} by {angle:deg0} clockwise, seen from above"
    TIP = "tip its upper side by {angle:deg0} towards {side}"
    MOVE = "move it by {far:mm0} towards {side}"
    RAISE = "raise it by {far:mm0}"
    LOWER = "lower it by {far:mm0}"
    FRONT = "the front wall"
    FRONT_LEFT = "the front left corner"
    LEFT = "the left wall"
    BACK_LEFT = "the back left corner"
    BACK = "the back wall"
    BACK_RIGHT = "the back right corner"
    RIGHT = "the right wall"
    FRONT_RIGHT = "the front right corner"


class DriftText(Text, subject="drift"):
    """What recorded scans say of the scanner since its calibration."""

    DRIFTED = (
        "the scanner has drifted since its calibration, as {thing} shows: at the corners of the "
        "bin the error has grown by {moved:mm2} (variation between days: {noise:mm2})"
    )
    BIN_MOVED = (
        "the bin appears {moved:mm2} from where it was in the first days (variation between days: "
        "{noise:mm2}), and nothing else shows that the scanner was moved: check which of the two "
        "was moved"
    )
    PARTS_ELSEWHERE = (
        "{count} parts that the robot has placed appear elsewhere, by more than the uncertainty "
        "of the calibration"
    )
    TOO_FEW_DAYS = "there are scans of {days} days; {fewest} are needed to compare them"
    NONE = "no drift within {days} days"
    OPEN = (
        "only the bin shows {axes:and} (shifts along axes, turns about them); fixtures in view, or "
        "parts placed there and turned, would show them too"
    )
    CORRECTED = (
        "with the scanner corrected by {moved:mm2} at the corners of the bin, the error there is "
        "{error:mm2} or less (95%)"
    )


class VerifyText(Text, subject="verify"):
    """Trueness by balls of known distances, and the touch test."""

    LENGTHS = "one length of a ball bar or three of a plate are needed, not {count}"
    BAR_LENGTH = "the length of a ball bar is more than the balls' diameter, and up to {longest} m"
    CENTRES = "{scan}: {count} centres of balls are needed"
    NOT_SEEN = (
        "{scan}: the balls are not all visible: {found} of {ball} mm are found, {count} at the "
        "stated distances are needed"
    )
    COVERED = "{scan}: a ball is covered on the scanner's side, or too few points show it"
    NO_SCAN = "no scan of the balls yet"
    LIMIT = "a limit is a length above 0 and below 1 m"
    TRUE = "lengths are true: {off:mm2} off at most, limit {limit:mm2}"
    NOT_TRUE = "lengths are not true: {off:mm2} off in {scan}, limit {limit:mm2}"
    SCALED = (
        "lengths are within the limit ({off:mm2} of {limit:mm2}), but on average too long or too "
        "short: the scanner's scale is wrong"
    )
    FEW_SCANS = "{true}; scan the balls in {advised} places or more"
    SAME_PLACE = "{few}; {scan} does not count: its balls lie where those of {other} do"
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
    ON_LINE = "the touched balls lie on one line, so a turn about it stays unseen: touch one off it"
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


class FirstScanText(Text, subject="first-scan"):
    """What in a first scan does not fit the cell, with the key to change."""

    NO_FIT = (
        "{path}: {share:%} of its points lie where a scanner measures, {near} to {far} m in front "
        "of it, in any unit and with any axes: is it a scan of this cell?"
    )
    RANGE = (
        "the cloud lies outside of the measuring range: near_mm = {near}, far_mm = {far} in "
        "[scanner]"
    )
    UNIT = 'the cloud is in {unit}: unit = "{unit}" in [scanner]'
    AXES = 'the cloud has other axes: cloud_axes = "{axes}" in [scanner] instead of {was}'
    FLOOR_ALONE = (
        "no rim is visible, but a floor: parts lie on {length:mm0} x {width:mm0}; --bin writes a "
        "bin of that size without walls"
    )
    AT_FLOOR = (
        "{path}: the floor is {height:mm0} from the cloud's origin, so the origin is not the "
        "scanner: export the points in the scanner's frame, or in the frame of the cell, z up"
    )
    IN_WORLD = (
        'the points are in the frame of the cell: cloud_axes = "world" in [scanner]; the scanner '
        "is assumed {above:mm0} above them"
    )
    BIN_MOVED = (
        "the bin appears {shift:mm0} and {turn:deg1} off: --bin writes where it is; position_mm, "
        "rpy_deg in [bin]"
    )
    NO_FLOOR = (
        "neither rim nor floor is visible: the floor is assumed {below:mm0} below the parts, which "
        "lie on {length:mm0} x {width:mm0}; --bin writes it, without walls"
    )
    NO_WALLS = (
        "the cell's bin has no walls, so no rim shows the scanner's pose: calibrate the scanner, "
        "or scan a bin with walls = true in [bin] first"
    )
    NO_BIN = (
        "no bin is visible: is it in the picture, with its rim? Without walls in the picture set "
        "walls = false and size_mm in [bin]"
    )
    OTHER_BIN = "a bin of {seen} mm is visible, in the cell {wanted} mm: size_mm in [bin]"
    OTHER_RIM = (
        "a rim of {length:mm0} x {width:mm0} is visible, not that of the cell's bin: is size_mm in "
        "[bin] right?"
    )
    RIM_SIZE = (
        "the rim measures {length:mm0} x {width:mm0} outside, in the cell {wanted_length:mm0} x "
        "{wanted_width:mm0}: is size_mm in [bin] right?"
    )
    FLOOR_DEPTH = (
        "the floor lies {depth:mm} below the rim, in the cell {wanted:mm}: size_mm in [bin]"
    )
    NOT_CALIBRATED = (
        "the bin appears {shift:mm0} and {turn:deg1} off: the scanner is not calibrated; "
        "position_mm, rpy_deg in [scanner]"
    )
    OFF = (
        "the bin appears {shift:mm0} and {turn:deg1} off: was it moved, or is the calibration old?"
    )


class BinText(Text, subject="bin"):
    """Where the bin is in a scan, and how full it is."""

    IN_PLACE = "the bin is where it should be, within {off:mm}"
    AT_HEIGHT = "parts lie as high as they should, within {off:mm}"
    FULL = "{bin}, {fill:%} full"
    NO_RIM = (
        "no rim of the bin within {reach:mm0} of its place in the cell: is the bin there, and are "
        "its size_mm and walls in the cell file right?"
    )
    RIM_COVERED = (
        "no rim of the bin within {reach:mm0} of its place in the cell: something is {above:mm0} "
        "above it; are its size_mm and walls in the cell file right?"
    )
    TOO_FULL = "the bin is too full: parts lie {above:mm0} above its rim"
    STANDS_OUT = "a part stands {above:mm0} above the rim"
    MOVED = (
        "the bin is {shift:mm} and {turn:deg1} from its place in the cell (x {x} mm, y {y} mm, z "
        "{z} mm): it was moved, or the scanner is not calibrated"
    )
    FLOOR_HIGHER = "the floor of the bin lies {off:mm} higher than in the cell"
    FLOOR_LOWER = "the floor of the bin lies {off:mm} lower than in the cell"
    HARDLY_SEEN = "the inside of the bin is hardly visible"
    ONLY_FLAT = "only things lower than {low:mm0} lie on the floor"
    EMPTY = "nothing higher than {lowest:mm} lies on the floor"
    EMPTY_AS_SEEN = (
        "nothing higher than {lowest:mm} lies on the {seen:%} of the floor that the scan shows"
    )
    OVERFILLED = "overfilled: parts lie {above:mm0} above the allowed height of {height:mm0}"
    STANDS_TOO_HIGH = "a part stands {above:mm0} above the allowed height of {height:mm0}"
    NO_SURFACE = (
        "no surface for the parts within {reach:mm0} of its height in the cell: is it there?"
    )
    SURFACE_MOVED = (
        "the surface that parts lie on is {off} mm from its height in the cell and leans by "
        "{turn:deg1} more: it was moved, or the scanner is not calibrated"
    )
    SURFACE_HARDLY_SEEN = "the surface that parts lie on is hardly visible"
    PARTS = "{count} {count:part|parts}"
    PARTS_OF = "{count} of about {about} parts"


class ScanText(Text, subject="scan"):
    """Why a scan, a detection or an obstacle cannot be used."""

    SHAPE = "a scan needs points of shape (n, 3), n > 0, not {shape}"
    NOT_FINITE = "a scan may hold finite points only; drop the empty ones first"
    PIXELS = "{points} points but {pixels} pixels"
    COLOURS = "{points} points but colours of shape {shape}"
    VIEWS = "the views of a scan with {points} points have another number together"
    ONLY_ROBOT = "the scan shows nothing but the robot: look at the view and the joints"
    COVARIANCE = "the covariance of a pose has six rows of six numbers"
    ROLL_AXIS = "the axis of a roll is a point and a direction of length 1"
    ROLL_POINT = "the axis of a roll goes through a point with finite coordinates"
    OBSTACLE_SIZE = "an obstacle needs three lengths above zero"
    PALLET_PART = "an obstacle that is a part on a pallet needs its kind and its pose"


class ObjectionText(Text, subject="objection"):
    """Why a hypothesis is not among the parts found, by the names of objections."""

    OUTSIDE = "outside the bin"
    TOO_LITTLE = "explains too little of the visible surface"
    FREE_SPACE = "violates free space"
    UNKNOWN = "something unknown explains it better"
    OUTDONE = "a part of another kind explains it and more"
    GOES_ON = "its surface continues where the part would end"
    COLOURS = "its colours are those of another kind"
    NOT_HELD = "a small shift explains it as well"
    CLAIMED = "another part explains its surface"
    TWIN = "a twin with a worse score"
    REACHES_INTO = "reaches into another part"
    RIVAL_FELL = "lost to a pose that was rejected as well"
    OF_PART = "{objection}: {part}"


class ScaleText(Text, subject="scale"):
    """What the parts found say of the size of a CAD file."""

    LARGE = "the CAD file of {part} seems {share}% too large for the scan"
    SMALL = "the CAD file of {part} seems {share}% too small for the scan"
    INSIDE = "the surface of {part} seems to lie {distance:mm} inside of its CAD file"
    AS_IT_IS = "the scan shows {part} in the size that it has"
    OUTSIDE = "the surface of {part} seems to lie {distance:mm} outside of its CAD file"

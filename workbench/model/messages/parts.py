"""What is wrong with parts, tools and piles, and what searches for parts and grasps report."""

from workbench.model.messages.message import Text


class PileText(Text, subject="pile"):
    """Why a pile cannot be made or emptied, and what any grasp could take of it."""

    NO_PART = "cell {cell} has no part, so there is nothing to drop into its bin"
    TOO_LARGE = "part {part} of {size} mm is too large for the bin of {room} mm"
    TOO_MANY = "{count} parts {parts} do not fit into the bin; take {most} or fewer"
    FALLEN_OUT = "{count} parts {parts} did not stay in the bin in {attempts} attempts; take fewer"
    CONTACTS = "the parts touch at too many points for the physics; take fewer parts"
    NO_GRASP = "part {part} has no grasp, so nothing can take it; create one first"
    NO_TOOL = (
        "no tool of cell {cell} fits a grasp of part {part}: all {count} grasps are refused, most "
        "of them because of this: {why}"
    )
    FOR_ARM = "the grasp is for arm {arms:or}"
    FOR_TOOL = "the grasp is for tool {tool}, arm {arm} carries {carried}"
    FOR_TCP = "the grasp is for TCP {tcp}, which tool {tool} does not have"
    OPENING = "the grasp needs an opening of {opening:mm}, tool {tool} opens {low:mm} to {high:mm}"
    INSIDE_OUT = "the mesh of part {part} is inside out; `workbench part import` turns it"
    NO_FINGERS = "no tool of cell {cell} has two fingers or a cup"
    NO_FACES = "no two opposite faces of part {part} fit between fingers: {strokes}"
    STROKE = "{tool} opens {low:mm} to {high:mm}"
    OF_TASK = "pile {number} of {count}"
    WITH_CHANGE = "{change}, {pile}"
    STEP = "{pile}: {step}"
    ANY_GRASP = (
        "a grasp that is not in the library takes it: arm {arm}, at {at} mm, pointing along "
        "{along} of the part, closed to {grip:mm0}"
    )
    NO_GRASP_FOUND = "no grasp takes it (of {tried} tested, {fits} fit, {holds} of these hold it)"
    NO_GRASP_SINCE = (
        "no grasp takes it (of {tried} tested, {fits} fit, {holds} of these hold it: {reasons})"
    )


class DrawnText(Text, subject="drawn"):
    """Why no tool can be made of drawings."""

    FINGER_SIZE = "a finger has three lengths"
    LENGTH = "{what} must lie between {low:mm} and {high:mm}"
    FORCE = "the force must lie between 0 and 100,000 N, not {value}"
    UNIT = "unit {unit} is not one of {known}"
    FLAT_TOOL = "{file} is flat, a tool is not"
    FLAT_FINGER = "{file} is flat, a finger is not"
    FINGER_SIDE = (
        "{file} reaches to x = {low:mm}: the finger is expected on the side of x above 0, as when "
        "closed"
    )
    TOO_LARGE = (
        "{tool} would reach {reach:mm0} from the flange, and {most:mm0} at most are allowed: is "
        "its drawing in another unit, or elsewhere than at the flange?"
    )
    TOO_SMALL = "{tool} would reach {reach:mm} from the flange: is its drawing in another unit?"
    MEETS = (
        "{tool} reaches into {body} with the arm at home: its drawing is expected in the flange's "
        "frame, z out of the flange"
    )
    DRAWING = "the offset of the drawing"
    BEGIN = "the beginning of fingers or cup"
    FINGER = "a finger"
    STROKE = "the stroke"
    CUP_RADIUS = "the radius of the cup"
    CUP_LENGTH = "the length of the cup"
    PRESS = "the compliance of the lip"


class PalletText(Text, subject="pallet"):
    """Pallets in layers: how full they are, and what is wrong with their places."""

    FILL = "{arm} pallet {number}: {parts} of {places}, layer {layer}"
    FULL = "{arm} pallet {number}: {parts} of {places}, full"
    DOUBTFUL = "{count} more may be there or not: check, and report when the pallets are empty"
    UNKNOWN_PART = (
        "a part {part} lies on a pallet, and the cell does not have that part any more; take it "
        "away and empty the pallets"
    )
    PROBLEM = "{arm} arm: pallet {number} of parts {part}: {problem}"
    NOTHING_BENEATH = "in layer {layer} nothing is within {far:mm0} beneath a part"
    FALLS = (
        "in layer {layer} a part is released {falls:mm} above its support; {least:mm} to {most:mm} "
        "are required"
    )
    PITCH = "{problem}: layers are {pitch:mm} apart, and the part is {high:mm} high"
    TOO_CLOSE = (
        "in layer {layer} a part comes within {near:mm} of one that lies there; the margin is "
        "{margin:mm}, so pitch_mm has to be larger"
    )
    IN_LAYER = "in layer {layer} {problem}"


class StationText(Text, subject="stand"):
    """Why no part can be taken from a station to its place."""

    PROBLEM = "station {station}, for {part}: {problem}"
    TOO_SMALL = "it is too small to stand on"
    TOO_CLOSE = "it brings a part within {margin:mm} of {body}"
    NOT_CARRIED = "it has nothing beneath it that would carry a part"
    UNREACHABLE = "it is out of reach of every arm"
    NO_GRASP = "no grasp takes a part from it to a place"
    UNSTABLE = "the part stands nowhere without falling over or rolling away"


class SymmetryText(Text, subject="symmetry"):
    """The symmetry that was found in a mesh."""

    FOUND = "{turns:and} ({symmetry}), {off:mm2} off at most"
    FOUND_THROUGH = "{turns:and}, through {point} mm ({symmetry}), {off:mm2} off at most"
    TURNS = "turns of {angle} degrees about {axis}"
    ANY_TURN = "any turn about {axis}"

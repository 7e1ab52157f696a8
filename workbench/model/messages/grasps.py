"""What checks of grasps find, which small change helps, and how exactly a part is placed."""

from workbench.model.messages.message import Text


class GripText(Text, subject="grip"):
    """What speaks against a grasp with a tool: the part alone, before any cell."""

    OTHER_TCP = "is for TCP {wanted}, not for this one of {tool}"
    OTHER_TOOL = "is for tool {wanted}, not for {tool}"
    CUTS = "{solid} cuts the part by {depth:mm}"
    CUTS_AT = "{solid} cuts the part by {depth:mm} at opening {opening:mm}"
    CUTS_ON_WAY = "{solid} cuts the part by {depth:mm} on the way in, {before:mm} before its end"
    CUTS_ON_WAY_AT = (
        "{solid} cuts the part by {depth:mm} on the way in, {before:mm} before its end, at opening "
        "{opening:mm}"
    )
    CUTS_CLOSED = "closed to {grip:mm}, {solid} cuts the part by {depth:mm}; {press:mm} are allowed"
    NOTHING_UNDER_CUP = "there is nothing under the cup"
    LIP_BEYOND = "{share:%} of the lip of the cup ({across:mm} across) lie beyond the part"
    UNEVEN = "the surface under the lip is uneven by {uneven:mm}; the lip gives way by {press:mm}"
    CUP_SHORT = "the cup ends {gap:mm} before the surface"
    OPENING = "opening {value:mm} is outside of the stroke, {low:mm} to {high:mm}"
    GRIP = "grip {value:mm} is outside of the stroke, {low:mm} to {high:mm}"
    NOTHING_BETWEEN = "there is nothing between the fingers"
    WIDTH = "the part is {width:mm} wide between the fingers, the grip {grip:mm}"
    INCLINED = "{finger} meets a face inclined by {angle:deg0} and would slip"
    SMALL_AREA = "{finger} touches {area} mm2 only"
    OFF_CENTRE = "the part lies {aside:mm} off centre: {finger} touches it first"
    HOLDS = "holds {times:1} times the load ({conditions})"
    TURNS_IN_FINGERS = "would turn in the fingers: {share:2} of the torque is held ({conditions})"
    TURNS_ON_CUP = "would turn on the cup: {share:2} of the torque is held ({conditions})"
    SLIPS_IN_FINGERS = "would slip in the fingers: {share:2} of the load is held ({conditions})"
    SLIPS_ON_CUP = "would slip on the cup: {share:2} of the load is held ({conditions})"
    CONDITIONS = "{force} N, friction {friction}, {acceleration:1} m/s2"


class FixText(Text, subject="fix"):
    """Small changes that make a refused candidate work."""

    NONE = (
        "no fix found: neither turns up to {turn} deg, {back} mm less depth, shifts up to "
        "{slide} mm, nor, for grippers, fingers {opening} mm less or more open"
    )
    NEAREST = (
        "nearest fix: {arm} arm, {part} by {grasp}: {change}; reach and collisions were tested, "
        "the grip was not"
    )
    ROLL = "make the roll of every part known: by another scan, or by hand"
    LIFTS = "allow other lifts as well (lifts: {lifts})"
    NEAR_MARGIN = "set near_margin, now {margin:mm}, to 0 on straight legs"
    MOVE_BIN = "move the bin by {by} mm along {axis}, or the robot's base by {back} mm"
    TURN = "turn the grasp about its approach axis by {angle} deg"
    LESS_DEEP = "grasp {by:mm0} less deep"
    SLIDE = "move the grasp by {by} mm along {axis} of the TCP"
    OPENING = "open the fingers {opening:mm0} wide on arrival"
    ON_GRASP = "Changes grasp {grasp} of {part}, for every part of this kind: {changes:and}"
    ON_PATTERN = (
        "Changes grasp {grasp} of {part} and its copies, for every part of this kind: {changes:and}"
    )
    ON_CELL = "Changes the whole cell, for all parts and arms: {changes:and}"
    LENGTH = "{name} from {before:mm} to {after:mm}"
    ANGLE = "{name} from {before:deg1} to {after:deg1}"
    LIFTS_CHANGED = "lifts from {before} to {after}"
    APPLIED = "nearest fix applied to {grasp}: {change}"
    APPLIED_TO_CELL = "nearest fix applied to the cell: {change}"
    GRASP_GONE = "grasp {grasp} does not exist any more"
    NOT_HERE = "this change cannot be made here: {change}"
    OUTDATED = "the parts were planned for again in the meantime; check the new fix"


class BudgetText(Text, subject="budget"):
    """How far from its target pose a part is placed, and where most of that comes from."""

    PLACED = (
        "placement error: {far:mm}, {turn:deg1} ({sure:%}); largest contribution: {source} ({axis})"
    )
    WITHIN = (
        "{error}; {chance:%} of picks are within the tolerances of the place, {tolerance:mm} and "
        "{turn_tolerance:deg1}"
    )
    MATES = "{error}; {chance:%} of picks mate with {base}"
    MATES_SELDOM = "{error}; {chance:%} of picks mate with {base}, {share:%} are asked for"
    SEEN_AGAIN = "{mating} (before {base} was seen: {before:%})"
    CALIBRATION = "calibration"
    LOCALIZATION = "localization"
    GRIP = "grip"
    ACROSS_PADS = "across the pads"
    ALONG_TRAVEL = "along the fingers' travel"
    ALONG_TOOL = "along the tool"
    ACROSS_TOOL = "across the tool"
    ABOUT_PADS = "about the line across the pads"
    ABOUT_TRAVEL = "about the fingers' travel"
    ABOUT_TOOL = "about the tool's axis"
    ABOUT_ACROSS = "about a line across the tool"

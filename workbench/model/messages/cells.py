"""What messages say of cells: how two of them differ, loads, drawn tools, and what has changed."""

from workbench.model.messages.message import Text


class DifferenceText(Text, subject="difference"):
    """How a cell differs from the one before."""

    CELL = "the cell was changed"
    MORE = "{first}; {count} more {count:difference|differences}"
    BIN = "the bin"
    ROBOT = "the robot"
    SCANNER = "the scanner"
    BIN_SIZE = "the bin has another size"
    REGIONS = "the regions of interest were changed"
    WALLS = "the bin has walls now"
    NO_WALLS = "the bin has no walls any more"
    ADDED = "{thing} was added"
    REMOVED = "{thing} was removed"
    MOVED = "{thing} was moved by {shift:mm}"
    TURNED = "{thing} was turned by {turn:deg1}"
    MOVED_AND_TURNED = "{thing} was moved by {shift:mm} and turned by {turn:deg1}"
    STATIONS = "the stations were changed"
    HOME = "the home of the {arm} arm was moved by up to {turn:deg1}"
    OTHER_TOOL = "the {arm} arm has another tool"
    OTHER_PLACES = "the {arm} arm has other places"
    KEY = "{key} was {old}, now it is {new}"
    PART_ADDED = "part {part} was added"
    PART_REMOVED = "part {part} was removed"
    PART_CHANGED = "part {part} was changed"
    GRASPS = "part {part} has other grasps ({changes})"

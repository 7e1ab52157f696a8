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
    RECIPE = "recipe {number} {name} was chosen"
    NO_RECIPE = "no recipe is chosen any more"
    RECIPES = "the recipes were changed"
    BINS = "the bins were changed"
    HOME = "the home of the {arm} arm was moved by up to {turn:deg1}"
    OTHER_TOOL = "the {arm} arm has another tool"
    TOOL_SLOTS = "the {arm} arm has other slots of tools"
    OTHER_PLACES = "the {arm} arm has other places"
    KEY = "{key} was {old}, now it is {new}"
    PART_ADDED = "part {part} was added"
    PART_REMOVED = "part {part} was removed"
    PART_CHANGED = "part {part} was changed"
    GRASPS = "part {part} has other grasps ({changes})"


class CellText(Text, subject="cell"):
    """Why a cell, or what is asked of it, cannot be used."""

    NO_ARM = "cell {cell} has no arm {name}; it has {known}"
    SCANNER_HANGS = (
        "the scanner of cell {cell} hangs on the {arm} arm; this is for scanners that stand"
    )
    NO_PART = "cell {cell} has no part {name}; it has {known}"
    NO_TCP = "tool {tool} has no TCP {name}; it has {known}"
    PICKS = "a scan can be followed by 1 to {most} picks, not {count}"
    PAIR_GAP = (
        "several picks after one scan need a pair_gap_mm in [policy]: without it nobody knows "
        "which parts move when one is taken"
    )
    STRATEGY = "strategy {strategy}: alternated, coordinated or the name of an arm is expected"
    TRIANGLE_COLOURS = "part {part} has {triangles} triangles but colours of shape {shape}"


class RecipeText(Text, subject="recipe"):
    """Recipes: chosen or not, and why one cannot be used."""

    CHOSEN = "recipe {number} {name} is chosen"
    NOT_CHOSEN = "no recipe is chosen"
    UNFIT = "{problem}; the cell is used as its file states it"
    NONE = "cell {cell} has no recipes"
    UNKNOWN = "cell {cell} has no recipe {number}; it has {known}"
    MISFIT = "recipe {number} {name} does not fit the cell: {problem}"
    NO_PART = "part {part} is not one of the cell's parts: {known}"
    NO_GRASP = "grasp {grasp} is not one of its parts' grasps: {known}"
    NOT_PICKED = "part {part} of the kit is not one of the recipe's parts: {known}"
    PART_WITHOUT_GRASP = "part {part} has no enabled grasp among those of the recipe"
    NO_PLACE = "place {place} is not one of the named places: {known}"
    ARM_WITHOUT_PLACE = "the {arm} arm has no place among those of the recipe"
    NO_STRATEGY = "strategy {strategy} is not one of {known}"
    NO_BIN = "bin {bin} is not one of the cell's bins: {known}"
    CELL_FIXED = "{command} has to wait while recipe {number} is chosen; choose no recipe first"
    STILL_PLACED = (
        "a part {part} stands on a pallet, and the recipe does not know it; empty the pallets first"
    )


class BinChoiceText(Text, subject="bin_choice"):
    """Bins: which one is picked from, what is known of them, and why one cannot be used."""

    CHOSEN = "parts are taken from bin {name}"
    EMPTY = "nothing is left to take in bin {name}"
    ALL_EMPTY = "nothing is left to take in any bin"
    NEW = "bin {name} is new"
    IN_USE = "bin {name} is picked from: say that it is new after the task or motion"
    ONLY = "cell {cell} has one bin only"
    UNKNOWN = "cell {cell} has no bin {name}; it has {known}"


class ViewChoiceText(Text, subject="view_choice"):
    """Views of a scanner on an arm: which one is chosen, and why one cannot be."""

    CHOSEN = "scans are taken from view {name}: go there"
    NEXT = "view {name} is next, as nothing can be taken from view {chosen}"
    MISSING = "view {name} is next, whose scan is merged with this one"
    OFF = (
        "view {name} does not fit the others: {shift:mm} and {turn:deg1} off, {share}% looked "
        "through; the calibration of the scanner or the robot is off"
    )
    NOTHING_FROM = "views from which nothing can be taken: {views:and}"
    UNKNOWN = "no view {name} sees this bin of cell {cell}; there is {known}"
    STANDS = "the scanner of cell {cell} hangs on no arm and has no views"


class AssemblyText(Text, subject="assembly"):
    """Assemblies: why a recipe cannot put a part onto another one of its kit."""

    NOT_EARLIER = "{part} is on {base}, and no earlier item of the recipe is {base}"
    CIRCLE = "{part} is on {base}, which is itself on {part}"
    COUNT = "the recipe has {count} {part}; of a part that is assembled it can have 1"
    NO_PLACE = "no arm has a place with part_position_mm for {base}, which another item is on"
    FROM_BELOW = "insert_along brings {part} to {base} from below"
    MOUTH = "mouth_mm lies {away:mm} outside of {base}"
    CHAMFER = "chamfer_mm {chamfer:mm} is not smaller than {part}, which reaches {half:mm} sideways"
    SEEN_BENEATH = (
        "look_again of {part} needs a bare {base}, and {other} is on it by then; leave the key out"
    )
    PASSED_ON = "the {arm} arm passes parts on, so that nothing can be assembled"


class SeenBaseText(Text, subject="seen_base"):
    """Where a scan shows the part of an assembly onto which another one comes, or why not."""

    SEEN = "{base} was seen {shift:mm} and {turn:deg1} off its believed pose"
    NO_SCAN = "{base} has to be seen in the scan that the parts were found in, and there is none"
    NOT_IN_VIEW = "{base} is not in the scanner's view; choose a view that shows its place"
    GONE = "the scan shows nothing where {base} is believed to stand"
    TOO_LITTLE = "only {visible:%} of {base} is seen, too little to state its pose"
    OTHER = "what stands in the place of {base} does not look like it"
    TOO_FAR = (
        "{base} was seen {shift:mm} and {turn:deg1} off its believed pose, at most {most:mm} and "
        "{most_turn:deg1} are allowed"
    )
    OFF_HEIGHT = (
        "{base} was seen {shift:mm} off its believed pose, of which at most {most:mm} up or down "
        "is allowed"
    )
    MOVED = "the views of the scan show {base} at two places; scan again once it stands still"
    PUT_SINCE = "{base} was put there after the scan; the next scan has to show it"
    EITHER = "a part in an assembly is either seen in a scan, or has a reason why not"
    COVARIANCE = "the covariance of a part that was seen has 6 rows and 6 columns"


class KitText(Text, subject="kit"):
    """Kits: what they have and lack, and what follows from that."""

    ITEM = "{count} of {of} {part}"
    STATE = "kit: {items}"
    LACK = "{count} {part}"
    LACKS = "the kit lacks {items}"
    COMPLETE = "the kit is complete; take it away and begin a new kit"
    NOT_FOUND = "the kit lacks {items}, and none was found; scan again, or begin a new kit"
    HAS_ENOUGH = "the kit needs no {part} now"
    BEGUN = "a new kit is begun"
    BEFORE = "{complete} {complete:kit|kits} complete, {incomplete} incomplete before it"
    TOTAL = "{complete} complete, {incomplete} incomplete"
    NOTHING = "the kit has no part yet"
    NOT_TAKEN_AWAY = "the kit has parts; take it away and begin a new kit first"
    NO_KIT = "no recipe with a kit is chosen"


class LoadText(Text, subject="load"):
    """What an arm carries, and why no body has such a load."""

    LOAD = "{mass} kg, centre of gravity {x}, {y}, {z} mm from the flange"
    BOTH = "tool {tool}; with the part {both}"
    IMPOSSIBLE = "this load is not possible: {problem}"
    MASS = "its mass is {mass} kg, more than 0 is expected"
    CENTRE = "its centre of gravity is not three numbers"
    INERTIA = "its inertia is not nine numbers"
    SYMMETRY = "its inertia is not symmetric"
    MOMENTS = "no body has its inertia: each moment is at least 0 and at most the sum of the others"


class SlotText(Text, subject="slot"):
    """Why an arm cannot change its tool for another one."""

    NO_TOOL = "the {arm} arm has no tool {name}, it can carry {known}"
    CARRIED = "the {arm} arm carries {tool} already"
    NO_SLOT = "{tool} of the {arm} arm has no slot: state it in the cell file, arm.tool_slot"
    NO_LINK = "robot link {link} couples no tools: change the tool by hand"
    JERK = "arm {arm} has jerk_deg: how fast it is at a slot cannot be proven"
    CHANGING = "the {arm} arm changes its tool: wait for the end"
    UNKNOWN = "nobody has stated which tool the {arm} arm carries: state it in the tab Cell"


class InventoryText(Text, subject="inventory"):
    """How software, machine, cell and people differ from those at the start before."""

    VERSION = "{name} {was} is now {has}"
    ADDED = "{name} {has} was added"
    REMOVED = "{name} {was} was removed"
    FILES = "the files of {name} {version} were changed"
    PARTS = "parts of the cell were changed: {parts}"
    CALIBRATION = "the scanner's pose was changed"
    CELL = "the cell was changed"
    NEW_USER = "new user {name} ({has})"
    USER_GONE = "user {name} ({was}) was removed"
    USER_ROLE = "user {name} is {has} now, was {was}"


class CommissioningText(Text, subject="commissioning"):
    """Steps of commissioning: what was verified, or what is missing."""

    LOADS = "Every tool has its mass, so the controller gets the load."
    NO_LOAD = "State mass_g of {tools:and} in the cell file: the controller gets no load."
    CALIBRATED = "The scanner was calibrated {days} {days:day|days} ago."
    CALIBRATION_OLD = "The calibration is {days} {days:day|days} old. Calibrate the scanner again."
    MERGED = "Each of the merged scanners is calibrated."
    SIMULATED = "A simulated scanner needs no calibration."
    NOT_CALIBRATED = "Calibrate the scanner: nobody has measured where it stands."
    GRASPS = "{count} {count:grasp|grasps} for the parts of the cell."
    NO_PART = "Make the part from its CAD file."
    NO_GRASPS = "Add grasps to {parts:and}: take suggestions, or fill the library."
    SCAN = "A scan was taken."
    NO_SCAN = "Take a scan of the bin."
    PARTS = "{count} {count:part was|parts were} found."
    PARTS_BEFORE = "Parts were found in an earlier cycle."
    NO_PARTS = "Find the parts in the scan."
    PLAN = "A plan was proven."
    NO_PLAN = "Plan a pick. The tab Candidates shows why a grasp is refused."
    PICKS = "{picked} of {count} {count:pick|picks} succeeded."
    NO_PICK = "Watch a plan, approve it and send it, first at low speed."
    SAVED = "The cell is saved."
    NOT_SAVED = "Save the cell."

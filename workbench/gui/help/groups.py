"""The help of each group of controls: opened by its question mark, read in place."""

from collections.abc import Generator, Mapping
from contextlib import contextmanager
from html import escape

import viser

SCAN, FIND, PLAN, SEND = "scan", "find-parts", "plan", "send"
GRASPS, CELL, CALIBRATION = "put-grasps-on-a-part", "change-the-cell", "calibrate-the-scanner"
TRUENESS = "check-the-calibration"
BACKUP, ACCEPTANCE, EMPTYING = "backup", "acceptance", "empty-a-full-bin-in-simulation"

THREE_COLUMNS_MARK = '<div class="wb-row"></div>'
"""A mark that has its folder laid out in three columns, see the style sheet."""

HELP: Mapping[str, tuple[str, str]] = {
    "Does a hand hold a part?": (
        "After a stop nobody knows whether a hand still holds a part, and no plan that takes one "
        "with it is approved. Look at the hand. Then have it dropped back, or state that it is "
        "empty.",
        "stop-faults",
    ),
    "1 · Scan": (
        "Everything begins with a scan of the bin: points, and where the bin is seen. In a "
        "simulated cell parts fall into the bin before; the same seed gives the same pile. A "
        "new scan ends what was found, planned and approved before.",
        SCAN,
    ),
    "2 · Find parts": (
        "The shape of each part that the cell picks is searched for in the scan. The tab Parts "
        "shows what was found, and how sure that is. What is wrong there can be corrected by "
        "hand.",
        FIND,
    ),
    "3 · Plan": (
        "Each grasp of each part is judged with each arm, and from those that can be taken a "
        "motion is planned. The threshold says from which distance on two arms may work at "
        "once, where the strategy is auto. Every plan is proven anew by code that shares "
        "nothing with planning.",
        PLAN,
    ),
    "4 · Approve, 5 · Send to the robot": (
        "A person who has watched the plan to its end approves it, by name, for one sending. "
        "Then Send has the controller run it, and exactly it. Stop here is no safety function: "
        "in danger use the emergency stop.",
        SEND,
    ),
    "Result of each pick": (
        "Report for each part whether its pick succeeded. A part whose pick failed is left "
        "alone for some scans, and three failures in a row are a fault. The statistics count "
        "what is said here.",
        "say-what-became-of-the-parts",
    ),
    "How it is planned": (
        "These are overrides for the next planning, and begin as the cell has them. More "
        "iterations find ways that are harder to find; a larger margin keeps farther from "
        "everything. The proof holds every plan to the margins of the cell, whatever is wished.",
        PLAN,
    ),
    "Search again in this scan": (
        "The same scan is searched with more detail, or with another seed. What it finds is "
        "drawn beside the parts found. Nothing is taken before you press Take this one.",
        FIND,
    ),
    "Keep as a case": (
        "A scan in which something was found wrongly, or missed, is kept with what was found and "
        "with what you say is there. Correct the parts first: what you do not correct counts as "
        "right. Every later version of the workbench can be compared with it.",
        FIND,
    ),
    "Commissioning": (
        "The steps from a new cell to its first pick, each checked by the program. A tick says "
        "that a step is done, the arrow which one is next. A click opens the tab for it.",
        CELL,
    ),
    "What is there": (
        "This lists what the cell is made of: robot, arms, tools, bin, fixtures and scanner. "
        "All of it is an obstacle for every plan. It comes from the cell file.",
        CELL,
    ),
    "Objects in the cell": (
        "Bin, scanner and fixtures can be moved, by numbers or by a gizmo. What was found and "
        "planned before is gone then. Undo takes a change back.",
        CELL,
    ),
    "Robot by hand": (
        "The see-through robot is moved here, in your browser alone: the real one stays where "
        "it is. The list says what it would touch, and how near it is. Where it stands can be "
        "taught as home or as a place.",
        CELL,
    ),
    "A tool from CAD": (
        "A file of the tool's body, and fingers or a cup in a few numbers, become a tool that the "
        "arm carries at once. The page shows what the file holds before you take it. Then its TCP "
        "is chosen above, to be moved by the gizmo or by numbers; Undo takes the tool away.",
        CELL,
    ),
    "Cell file": (
        "Changes of the cell count at once, and are in its file when they are saved. Comments "
        "in the file stay. The remark is kept beside it, with the time and your name.",
        CELL,
    ),
    "Where the hand is": (
        "The pose of the chosen grasp: where the tip of the tool is on the part, and how it is "
        "turned. It is moved by numbers, by the gizmo or by keys, or put at an offset from another "
        "grasp. Snap puts it square to the surface.",
        GRASPS,
    ),
    "How it takes the part": (
        "Opening and grip of the fingers, the ways in and out, and which arms may take this "
        "grasp. Measure fills in what the shape of the part gives. Apply takes what stands "
        "there.",
        GRASPS,
    ),
    "Copies and patterns": (
        "A grasp can be repeated around an axis and along it, and stays one entry of the list. "
        "Explode makes single grasps of it. Mirror puts one on the other side.",
        GRASPS,
    ),
    "Suggestions": (
        "Grasps are proposed for the shape of the part, the best ones first. A row that is "
        "clicked shows the hand there. None counts before you take it.",
        GRASPS,
    ),
    "Coverage of resting poses": (
        "Every grasp is tried however the part lies in the bin: tool against bin, and reach of "
        "the arms. What is coloured shows where none works. Add what helps takes a grasp that "
        "closes a gap.",
        GRASPS,
    ),
    "Symmetry of the part": (
        "Turns that leave the part as it looks: each grasp counts at every one of them. Look "
        "proposes what the mesh has, Confirm takes it. Parts are found anew with it.",
        GRASPS,
    ),
    "Pairs for two arms": (
        "A pair says which grasp of one arm goes with which of the other, where both arms take "
        "parts. In this order means that the arm with the first one goes first. Without any "
        "pair all go with each other.",
        GRASPS,
    ),
    "Save and versions": (
        "Edits count at once, for everybody, and are in the part's folder when they are saved. "
        "Each saving is a version with a remark. What an earlier session has not saved is kept "
        "as a draft.",
        GRASPS,
    ),
    "Versions": (
        "Every saving of the grasps of this part is kept. An earlier one can be viewed and "
        "brought back. That is an edit like any other, and can be undone.",
        GRASPS,
    ),
    "New part from a CAD file": (
        "A part is made of a file: STEP, STL, OBJ or PLY. Where the file has no unit, say it. "
        "The part is in the cell then, without grasps.",
        GRASPS,
    ),
    "Piles to empty": (
        "Parts fall into a simulated bin, and plan after plan takes them out, until nothing can be "
        "taken any more. The cell is tried as it is now, with what is not saved yet. While it runs "
        "the worker does nothing else; Cancel task ends it.",
        EMPTYING,
    ),
    "What came of it": (
        "What all piles together have brought, and each of them in a row. A click on a heading "
        "sorts, a click on a row chooses the pile for the film. Touches and failed picks should be "
        "none: where there are some, margins or poses are not what they should be.",
        EMPTYING,
    ),
    "Film of the chosen pile": (
        "The see-through robot takes the parts as planned, the rest settles, and the next plan "
        "follows. At the end each part that stays is coloured by why; a click on it or on its row "
        "marks both. You alone see it: the solid robot is the real one.",
        EMPTYING,
    ),
    "How the piles went empty": (
        "Parts taken after each pick, a curve for each pile. Where a curve is level a pick has "
        "failed. It ends with the last pick: what is missing to the full pile stays in the bin.",
        EMPTYING,
    ),
    "What changes bring": (
        "The same piles were emptied with single changes of the cell, one at a time. Those that "
        "gain most come first. Nothing of the cell was changed by that.",
        EMPTYING,
    ),
    "Seconds of people and scanner": (
        "What a scan takes, and a person who approves a plan. They count in the parts an hour, "
        "beside the motion and the computing as measured here. They change nothing else.",
        EMPTYING,
    ),
    "1 · Plate": (
        "The calibration looks for a plate of three balls. An arm holds it, or it stands and the "
        "arm carries the scanner. Wrong sizes make a wrong calibration.",
        CALIBRATION,
    ),
    "2 · Poses": (
        "Bring the robot to a pose in which the scanner sees the plate, and scan it. Eight "
        "poses are good, four are the least. They should differ much, in place and in turn.",
        CALIBRATION,
    ),
    "Acceptance": (
        "The record by which a customer accepts the cell, of this session. It compares the last "
        "picks with what was agreed, and states causes and the steps of commissioning. A pick "
        "whose result nobody reported counts as not taken.",
        ACCEPTANCE,
    ),
    "Restore a backup": (
        "A backup that was taken here, or with the command, is read as a whole, and what it would "
        "change is listed before anything is. Restoring keeps what is there now as a backup "
        "first. What has changed of the cell is read again at once; sessions that are there stay.",
        BACKUP,
    ),
    "3 · Review and apply": (
        "From all poses follows where the scanner hangs; green lights are within 1 mm and 0.3 "
        "degrees. A pose that is wrong can be left out. Apply changes the cell, Save to file "
        "keeps it.",
        CALIBRATION,
    ),
    "5 · Trueness": (
        "Lay the plate, or a ball bar, where parts lie and scan it in three places or more. The "
        "distances of the balls are compared with the stated ones: sphere-spacing error. The same "
        "sign everywhere means that the scanner's scale is wrong.",
        TRUENESS,
    ),
    "6 · Touch test": (
        "Scan the plate where parts lie and leave it there. Jog the robot until its tool tip sits "
        "on a ball, then record the joints; three balls or more. Nothing moves by itself. The "
        "offsets are compared with the error that the calibration predicts.",
        TRUENESS,
    ),
    "4 · Drift": (
        "The recorded scans of every day are held against each other: bin and fixtures stand "
        "still, parts stand where the robot has put them. So it shows whether the scanner still "
        "hangs where it was calibrated. Move the scanner changes the cell, Undo takes that back.",
        CALIBRATION,
    ),
}
"""By the name of the group: three sentences, and the section of the manual."""


def help_html(name: str) -> str:
    """A question mark that opens what a group is for."""
    text, section = HELP[name]
    return (
        f'<details class="wb-help"><summary title="What this is for" '
        f'aria-label="Help">?</summary><p>{escape(text)} '
        f'<a href="/manual#{section}" target="_blank" rel="noopener">In the manual</a></p>'
        "</details>"
    )


@contextmanager
def group(
    gui: viser.GuiApi, name: str, *, expand_by_default: bool = True
) -> Generator[viser.GuiFolderHandle]:
    """A group of controls with its help: what is added meanwhile belongs to it."""
    with gui.add_folder(name, expand_by_default=expand_by_default) as folder:
        gui.add_html(help_html(name))
        yield folder

"""What is wrong with a file, behind its path."""

from workbench.model.messages.message import Text


class FileText(Text, subject="file"):
    """A problem with the file or the key that has it."""

    PROBLEM = "{path}: {problem}"
    KEY = "key {key}: {problem}"
    WITHIN = "{file} in it {problem}"
    INVALID = "{detail}"


class FileProblem(Text, subject="file-problem"):
    """What people mend by another file, or by how they export it."""

    MISSING = "there is no such file"
    RESTORES_NOW = "somebody restores a backup just now"
    NO_MESH = "is no mesh that can be read: one of {kinds} is expected"
    NO_CAD_FILE = "is no CAD file that can be read: one of {kinds}"
    UNREADABLE = "cannot be read as {kind}: {detail}"
    CUT_OFF = "is cut off: {detail}"
    BROKEN = "is cut off, or no {kind} file: {detail}"
    NO_ZIP = "is no zip file that can be read, or is cut off"
    NO_KIND = "is not a {kind} file: {detail}"
    NOT_TEXT = "is not a text file in UTF-8"
    NOT_VALID = "is not valid {kind}: {detail}"
    NOT_WRITTEN = "not written: {problem}"
    UNWRITABLE = "not written: something was changed that cannot be written into the file"
    NO_FILE_NAME = "is not the name of a file"
    NAME = "{name} is not the name of a file: / and \\ and control characters are not taken"
    EXISTS = "is there already; choose another name, or remove it first"
    TOO_LARGE = "is longer than {most} MB, the most that is read"
    UNPACKS = "unpacks to more than {most} MB"
    TIME = "could not be read within {seconds:s}"
    MEMORY = "cannot be read with {most} MB of memory"
    ENDED = "cannot be read: it made its reader end (code {code})"
    INTERNAL = "cannot be read: internal error, see the log"
    DEEP = "cannot be read: its parts are nested too deeply"
    CANCELLED = "reading was cancelled"

    CASE_TOO_LARGE = "would have {size} MB; up to {most} are stored"
    NO_CASE = "is no case that can be read: {detail}"
    NO_BACKUP = "is no backup of a workbench"
    OTHER_BACKUP = "is no backup that can be restored: {detail}"
    NOT_RESTORED = "not restored: {reason}"
    HOLDS_USERS = "the backup holds users: restore it from a shell"

    NO_TRIANGLES = "holds no triangles"
    NO_SURFACE = (
        "holds points that no surface joins; make the model of several scans "
        "(`workbench part from-scans`)"
    )
    TRIANGLES = "has {count} triangles, {most} are allowed"
    EXPORT = "has {count} triangles: export it with {most} at most"
    EXPORT_OPEN = (
        "has {count} triangles and is not closed, so it cannot be simplified: export it with "
        "{most} at most"
    )
    NOT_FINITE = "holds a point that is not finite"
    NO_CORNER = "has a triangle with a corner that does not exist"
    FLAT = "is flat: all its points lie in one plane"
    HUGE = "would be {size} m large; if it is in millimetres, scale it by 0.001"
    NEEDS = "needs {name}, which is not in the same folder"
    NO_CAD = "holds no CAD file; one is expected"
    SEVERAL_CAD = "holds {count} CAD files: {names}; one is expected"
    NO_UNIT = "does not say its unit ({meanings}): say which (--unit)"
    UNIT = "unit {unit} is not one of {known}"
    OTHER_UNIT = "would be {size} mm large: give another unit (--unit)"
    OTHER_UNIT_OF = "would be {size} mm large ({meanings}): give another unit (--unit)"
    NO_SOLID = "has no solid {solid}; there are {solids}"
    NO_SOLIDS = "cannot be read as STEP, or holds no solid"
    NO_SHAPE = "holds no shape: its parts are in other files, import {names}"
    NO_COLOURS = "has no colours, which use_colours asks for"
    SOME_COLOURS = "has colours of some of its bodies, and use_colours asks for all"
    COLOURS = "its colours cannot be used: {detail}"
    NOT_CLOSED = "its surface is not closed: {problems}; {repair}"
    REPAIR = (
        "have it mended (--repair), or take it as it is, to be found in scans (--open --mass-g)"
    )
    NOT_REPAIRED = (
        "it could not be repaired; take it as it is, to be found in scans (--open --mass-g)"
    )
    NO_VOLUME = "its surface encloses nothing"
    NO_MASS = "is open, so its mass is not known: give it (--mass-g)"
    MASS = "would be {size} mm and weigh {mass}: give another unit (--unit) or its mass (--mass-g)"
    PART_NAME = "name {name}: letters, digits, - and _ are expected, 1 to 60 of them"

    NO_CLOUD = "is neither a PLY nor a PCD file"
    EMPTY = "is an empty cloud: none of its {count} points was measured"
    POINTS = "declares {count} points, at most {most} are read"
    OUT_OF_RANGE = (
        "its points are {nearest} to {farthest} m from the scanner when read in {unit} ({key}). "
        "The scanner measures from {near} to {far} m (near_mm, far_mm). Is the file in another "
        "unit ({units})? `workbench scanner fit` finds it, or Fit scanner to file in tab Parts"
    )
    FAR = (
        "the furthest point is {reach} m from the scanner when read in {unit}; expected {near} to "
        "{far} m. Is the file in another unit ({units})? `workbench scanner fit` finds it, or Fit "
        "scanner to file in tab Parts"
    )
    BEHIND = (
        "nearly all of its points lie behind the scanner when its axes are taken for {axes}: "
        "cloud_axes in [scanner] of the cell file is another of {known}. `workbench scanner fit` "
        "finds it, or Fit scanner to file in tab Parts"
    )

"""Texts of the tab Parts, and of CAD files that people upload."""

from workbench.model.messages.message import Text


class PartsText(Text, subject="page-parts"):
    """Parts found, avoided and rejected; cases that are stored."""

    PLACE = "{part} at {x}, {y} mm in the bin"
    AVOIDED_NOW = "avoided in this scan, at most {minutes} min"
    AVOIDED_FOR = "avoided for {scans} more {scans:scan|scans}, at most {minutes} min"
    NOTED = "{text} ({why})"
    WATCHED = "Poses that come into {folder} are taken over."
    REJECTED = "{count} rejected {count:hypothesis|hypotheses}"
    HYPOTHESIS = "{score:2} {part}: {why}"
    STORED = "stored as {path}"
    TAKEN = "the {arm} arm takes it"
    TAKEN_BY_BOTH = "{arms:and} take it, one after the other"
    LEFT_UNTRIED = "Not taken: no grasp was tried"
    LEFT_FOR_LATER = "Left for a later plan: {count} {count:grasp|grasps} {count:works|work}"
    LEFT_STIRRED = "Not taken: this plan only stirs; before it, {count} {count:grasp|grasps} worked"
    LEFT_WITHOUT_PLAN = (
        "Not taken: no plan ({verdict}); {count} {count:grasp|grasps} {count:works|work} apart "
        "from that"
    )
    LEFT = "Not taken: {verdict}; {grasp}, {arm} arm, got farthest of {count}"


class UploadText(Text, subject="page-upload"):
    """A CAD file that a person chose."""

    MEGABYTES = "{file}, {size:1} MB"
    KILOBYTES = "{file}, {size} kB"
    READING = "{file}: reading …"
    LOOK = "{file}: {facts}"
    FAILED = "{file} cannot be read"
    AS_STATED = "unit as the file states"
    ASSUMED = "assumed unit {unit}"
    READ_IN = "unit {unit}"
    SIZE = "{size} mm, {unit}; z from {low} to {high} mm"
    CLOSED = "{text}; closed, {volume} cm³"
    NOT_CLOSED = "{text}; not closed: {problems}"
    MASS = "Mass: {mass} g."

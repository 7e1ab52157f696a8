"""Texts of the tab Statistics, and of backups there."""

from workbench.model.messages.message import Text


class StatisticsText(Text, subject="page-statistics"):
    """Counts and rates of a session, and what restoring a backup changes."""

    WOULD_CHANGE = "Changes by {name}:"
    CELL = "Cell {name}"
    PART = "Part {name} with its grasps"
    SESSION = "Session {name}"
    TAKEN = "{taken}, {failed} failed"
    DROPPED_AND_DOUBLE = "{dropped} dropped, {double} double"
    RATE = "{count}, without pauses between cycles"
    SUCCESS_BY = "Success by {group}"
    BY_HOUR = "Parts taken in each hour [{zone}]"
    MEDIAN_TIME = "{median}, most {most}"
    KITS = "Kits by recipe {recipe}"
    DROPPED_BACK = "{times} {times:time|times}, {parts} {parts:part|parts}"
    DROPPED_UNKNOWN = "{known}; {unknown} {unknown:time|times} nobody knows how many"
    TAKEN_OF = "{taken} of {total}"
    READING = "{name}: reading …"
    RESTORING = "{name}: restoring …"
    RESTORED = (
        "{name} is restored; the state before it is stored as {before}. The cell is read again "
        "where its files have changed."
    )
    PROGRESS = "{done:%}: {note}"

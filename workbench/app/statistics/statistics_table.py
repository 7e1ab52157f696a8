"""What a session has brought as a table for spreadsheets."""

import csv
import io
from datetime import UTC, datetime

from workbench.app.statistics.statistics import STAGES, Statistics


def csv_text(value: Statistics) -> str:
    """A row for each part that was sent for, with a head; times in seconds, UTC."""
    out = io.StringIO()
    writer = csv.writer(out)
    stages = [f"{stage.replace(' ', '_')}_s" for stage in STAGES]
    head = ("scan_at", "end_at", "end", "strategy", "arm", "part", "grasp", "result", "why")
    writer.writerow((*head, *stages))
    for cycle, pick in value.picks:
        times = (datetime.fromtimestamp(at, UTC).isoformat() for at in (cycle.at, cycle.until))
        seconds = [f"{cycle.seconds[s]:.3f}" if s in cycle.seconds else "" for s in STAGES]
        writer.writerow(
            (
                *times,
                cycle.end,
                cycle.strategy,
                pick.arm,
                _cell(pick.part),
                _cell(pick.grasp),
                pick.result,
                _cell(pick.why),
                *seconds,
            )
        )
    return out.getvalue()


def _cell(text: str) -> str:
    """A text that no spreadsheet takes for a formula."""
    return f"'{text}" if text[:1] in ("=", "+", "-", "@", "\t", "\r") else text

"""`workbench statistics`: what recorded sessions have brought, as tables, JSON or CSV."""

from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workbench.app.core.state import format_count as number_of
from workbench.app.records.session_archive import open_journal, sessions_in
from workbench.app.statistics.statistics import (
    GROUPS,
    Statistics,
    statistics,
    together,
)
from workbench.app.statistics.statistics_table import csv_text
from workbench.cli.arguments import top as arguments
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import milliseconds, print_json, print_table
from workbench.formats.files.whole_files import write_whole
from workbench.model.errors import InputError


def print_statistics(typed: arguments.StatisticsArguments) -> int:
    """Count what the sessions tell."""
    folders = typed.sessions or sessions_below(Path("sessions"))
    counted = together(_count(folder) for folder in folders)
    if typed.csv is not None:
        write_whole(typed.csv, csv_text(counted).encode())
    if typed.json:
        print_json(_form(counted, len(folders)))
        return SUCCESS
    _print(counted, len(folders))
    if typed.csv is not None:
        print(f"{len(counted.picks)} rows written to {typed.csv}")
    return SUCCESS


def sessions_below(root: Path) -> tuple[Path, ...]:
    """The folders of all sessions in a folder; see `sessions_in`.

    Raises:
        InputError: there are none.
    """
    found = sessions_in(root)
    if not found:
        raise InputError(f"{root}: there are no sessions of yours in it; name the folders of some")
    return found


def _count(folder: Path) -> Statistics:
    with closing(open_journal(folder)) as journal:
        return statistics(journal.entries())


def _form(counted: Statistics, sessions: int) -> dict[str, Any]:
    return {
        "sessions": sessions,
        "cycles": len(counted.cycles),
        "picked": counted.picked,
        "picks_per_hour": counted.picks_per_hour,
        "success": {
            name: {rate.name: rate.counts for rate in counted.rates(of)}
            for name, of in GROUPS.items()
        },
        "stages": {
            stage: {"median_ms": milliseconds(usual), "most_ms": milliseconds(most)}
            for stage, usual, most in counted.stage_medians()
        },
        "refusals": dict(counted.refusals),
        "kits": [asdict(kit) for kit in counted.kits],
        "dropped_back": asdict(counted.drops),
    }


def _print(counted: Statistics, sessions: int) -> None:
    rate = counted.picks_per_hour
    said = "" if rate is None else f", {rate:.0f} for each hour of cycles"
    named = f"{number_of(sessions, 'session')}, {number_of(len(counted.cycles), 'cycle')}"
    print(f"{named}, {number_of(counted.picked, 'part')} taken{said}")
    for kit in counted.kits:
        kits = f"{number_of(kit.complete, 'kit')} complete, {kit.incomplete} incomplete"
        print(f"recipe {kit.recipe}: {kits}")
    if (drops := counted.drops).times:
        unknown = f"; how many is not known of {drops.unknown}" if drops.unknown else ""
        print(f"dropped back {number_of(drops.times, 'time')}, {drops.parts} parts{unknown}")
    rows = [
        (
            group,
            group_rate.name,
            str(group_rate.picked),
            str(group_rate.failed),
            str(group_rate.dropped),
            str(group_rate.double),
            f"{group_rate.share:.0%}",
        )
        for group, of in GROUPS.items()
        for group_rate in counted.rates(of)
    ]
    print_table("Success", ("by", "", "taken", "failed", "dropped", "double", "share"), rows)
    stages = [
        (stage, f"{milliseconds(usual):,}", f"{milliseconds(most):,}")
        for stage, usual, most in counted.stage_medians()
    ]
    print_table("Time of each stage", ("stage", "median ms", "largest ms"), stages)
    causes = [(reason, f"{count:,}") for reason, count in counted.refusals]
    print_table("Why candidates were refused", ("reason", "candidates"), causes)

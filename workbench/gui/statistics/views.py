"""Statistics as HTML: a few numbers, and bars; see `views` for how."""

from collections import Counter
from collections.abc import Mapping, Sequence
from html import escape

from workbench.app.core.state import Phase, State
from workbench.app.records.restoring import Thing
from workbench.app.statistics.cycles import Rate
from workbench.app.statistics.drops import DropCount
from workbench.app.statistics.kits import KitCount
from workbench.app.statistics.remaining import remaining_words
from workbench.app.statistics.statistics import GROUPS, Statistics
from workbench.gui.shared.colours import BAD, BRAND
from workbench.gui.shared.views import line, table_html, time_of_day, zone
from workbench.gui.texts.statistics import StatisticsText
from workbench.model.candidate import Reason
from workbench.model.messages.cells import KitText
from workbench.model.messages.message import Message, plain
from workbench.model.messages.work import LinkText
from workbench.model.release import PickResult
from workbench.words.words import IN_ENGLISH, Words

MOST_BARS = 12
"""Of one chart; a part may have very many grasps."""


UNWANTED = (PickResult.FAILED, PickResult.DROPPED, PickResult.DOUBLE)


def not_restored(state: State, robot: Message | None) -> str:
    """Why no backup may be restored now; empty when it may.

    Args:
        state: as it is.
        robot: what the controller reports, in words; empty: nothing.
    """
    if state.phase is Phase.APPROVED:
        return "a plan is approved: send it, or make another, before something is restored"
    if robot is not None and robot.text is LinkText.MOVES:
        return "the robot moves: wait until it stands"
    if not state.is_saved:
        return "the cell has changes that nobody has saved: save or undo them first"
    return ""


def changes_any(things: Sequence[Thing]) -> bool:
    """Whether restoring changes something."""
    return any(thing.fate in ("new", "replaced") for thing in things)


FATES: Mapping[str, str] = {
    "new": "is new here",
    "replaced": "is replaced",
    "the same": "stays the same",
    "left as it is": "is left as it is",
}


def things_html(name: str, things: Sequence[Thing], words: Words = IN_ENGLISH) -> str:
    """What a backup would change, thing by thing."""
    rows = [(words.render(_label(thing)), FATES[thing.fate]) for thing in things]
    return line(words.render(StatisticsText.WOULD_CHANGE(name=name))) + table_html(rows)


def _label(thing: Thing) -> Message:
    match thing.kind:
        case "robots":
            return StatisticsText.CELL(name=thing.name)
        case "parts":
            return StatisticsText.PART(name=thing.name)
        case _:
            return StatisticsText.SESSION(name=thing.name)


def statistics_html(counted: Statistics, words: Words = IN_ENGLISH) -> str:
    """The statistics of a session."""
    if not counted.cycles:
        return line("Once a cycle was planned, what came of it is counted here.", kind="hint")
    rate = counted.picks_per_hour
    results = Counter(pick.result for _, pick in counted.picks)
    failed, dropped, double = (results[result] for result in UNWANTED)
    taken = StatisticsText.TAKEN(taken=counted.picked, failed=failed)
    lost = StatisticsText.DROPPED_AND_DOUBLE(dropped=dropped, double=double)
    hourly = None if rate is None else StatisticsText.RATE(count=round(rate))
    rows = [
        ("Cycles", f"{len(counted.cycles)}"),
        ("Parts taken", words.render(taken)),
        *([("Other outcomes", words.render(lost))] if dropped or double else []),
        *([] if hourly is None else [("Parts per hour", words.render(hourly))]),
        *(_kit_row(kit, words) for kit in counted.kits),
        *([("Dropped back", words.render(_dropped(counted.drops)))] if counted.drops.times else []),
    ]
    hours = counted.by_hour()
    charts = [
        *(
            _success(StatisticsText.SUCCESS_BY(group=plain(name)), counted.rates(of), words)
            for name, of in GROUPS.items()
        ),
        _bars(
            words.render(StatisticsText.BY_HOUR(zone=zone(hours[-1][0]))) if hours else "",
            [(time_of_day(at)[:5], picked, f"{picked}") for at, picked, _ in hours],
        ),
        _bars(
            "Median time of each stage",
            [
                (stage, usual, words.render(_median(usual, most)))
                for stage, usual, most in counted.stage_medians()
            ],
        ),
        _bars(
            "Why candidates were refused",
            [
                (words.render(Reason(reason).message), count, f"{count:,}")
                for reason, count in counted.refusals
            ],
        ),
        _chart(
            "Parts left when no plan was found",
            [line(words.render(said)) for said in remaining_words(counted.remaining)[:MOST_BARS]],
        ),
    ]
    return table_html(rows) + "".join(charts)


def _dropped(drops: DropCount) -> Message:
    known = StatisticsText.DROPPED_BACK(times=drops.times, parts=drops.parts)
    if not drops.unknown:
        return known
    return StatisticsText.DROPPED_UNKNOWN(known=known, unknown=drops.unknown)


def _kit_row(kit: KitCount, words: Words) -> tuple[str, str]:
    total = KitText.TOTAL(complete=kit.complete, incomplete=kit.incomplete)
    return words.render(StatisticsText.KITS(recipe=kit.recipe)), words.render(total)


def _median(usual: float, most: float) -> Message:
    return StatisticsText.MEDIAN_TIME(median=_seconds(usual), most=_seconds(most))


def _seconds(time: float) -> str:
    return f"{time:.1f} s" if time >= 10 else f"{time:.2f} s"


def _success(title: Message, rates: tuple[Rate, ...], words: Words) -> str:
    """A bar for each, its length the share that was taken."""
    known = [rate for rate in rates if rate.known]
    bars: list[str] = []
    for rate in known[:MOST_BARS]:
        taken = StatisticsText.TAKEN_OF(taken=rate.picked, total=rate.known)
        bars.append(_bar(rate.name, 100 * rate.share, words.render(taken), BAD))
    return _chart(words.render(title), bars)


def _bars(title: str, values: list[tuple[str, float, str]]) -> str:
    """A bar for each of the last names, its length in proportion to the largest value."""
    shown = values[-MOST_BARS:]
    largest = max((value for _, value, _ in shown), default=0.0) or 1.0
    return _chart(title, [_bar(name, 100 * value / largest, text) for name, value, text in shown])


def _bar(name: str, percent: float, text: str, rest: str = "transparent") -> str:
    return (
        f'<div class="wb-lane"><span class="wb-stat-name" title="{escape(name)}">{escape(name)}'
        f'</span><div class="wb-stat-track" style="background:{rest}"><i style="width:'
        f'{percent:.1f}%;background:{BRAND}"></i></div>'
        f'<span class="wb-stat-value">{escape(text)}</span></div>'
    )


def _chart(title: str, bars: list[str]) -> str:
    if not bars:
        return ""
    return f'<div class="wb-stat"><b>{escape(title)}</b>{"".join(bars)}</div>'

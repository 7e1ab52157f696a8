"""Curves as HTML: over the time of a plan with a cursor in all, where a click goes to its time.

viser's plots cannot do either, and stay blank when the colours of the page change while they are
out of sight (decision 2).  These are as wide as there is room, and take their colours from the
style sheet.
"""

import math
from dataclasses import dataclass
from html import escape
from itertools import pairwise

import numpy as np

from workbench.model.geometry import Floats

PLOT_WIDTH, PLOT_HEIGHT = 1000.0, 100.0
"""Of the drawing, in its own units: it is stretched to the room there is."""

MOST_TICKS = 5

MOST_ALONG = 90.0
"""[%] Numbers along the axis are centred up to here; farther on they would leave the plot."""

MOST_COLUMNS = 500
"""Of a drawn curve: of each column of its samples the lowest and the highest are drawn."""

COUNTED = ("cycle",)
"""Axes along which things are counted."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """One curve: its name, `colour` and values (k,) at the plot's times; NaN where it has none.

    Values are in the plot's own unit.
    """

    name: str
    colour: str
    values: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Plot:
    """Curves over the same `times` (k,) [s], or over what `along` names.

    What is shown reaches from `low` to `high` at least.  Each of the `limits` is a dashed line at a
    value, in a colour.
    """

    title: str
    unit: str
    times: Floats
    curves: tuple[Curve, ...]
    low: float = math.inf
    high: float = -math.inf
    along: str = "s"
    limits: tuple[tuple[float, str], ...] = ()

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest value that is shown."""
        values = np.concatenate([curve.values for curve in self.curves])
        known = np.append(values[np.isfinite(values)], [value for value, _ in self.limits])
        low, high = known.min(initial=self.low), known.max(initial=self.high)
        if not (math.isfinite(low) and math.isfinite(high)):
            return 0.0, 1.0
        return (float(low), float(high)) if high > low else (low - 0.5, low + 0.5)


def ticks(low: float, high: float, *, is_whole: bool = False) -> tuple[float, ...]:
    """Round numbers in a range, five at most, in steps of 1, 2 or 5 times a power of ten.

    Of what is counted there are none between whole numbers.
    """
    rough = (high - low) / MOST_TICKS
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * k for k in (1, 2, 5, 10) if power * k >= rough * (1 - 1e-9))
    step = max(step, 1.0) if is_whole else step
    first = math.ceil(low / step - 1e-9)
    last = math.floor(high / step + 1e-9)
    return tuple(k * step for k in range(first, last + 1))


def plot_html(plot: Plot, end: float, slider: str = "") -> str:
    """A plot from 0, or where its times begin, to `end`.

    Args:
        plot: what is drawn.
        end: of the axis along: how long the plan is.
        slider: id of the slider of the time, which a click puts where the time is; none: no
            cursor either.
    """
    low, high = plot.bounds
    begin = min(0.0, float(plot.times[0])) if slider else float(plot.times[0])
    lines = "".join(_line(plot.times, curve, (low, high), (begin, end)) for curve in plot.curves)
    across = "".join(
        f'<i class="wb-grid" style="bottom:{_share(tick, low, high):.2f}%"><b>{tick:g}</b></i>'
        for tick in ticks(low, high)
    )
    across += "".join(
        f'<i class="wb-limit" style="bottom:{_share(value, low, high):.2f}%;'
        f'border-color:{colour}"></i>'
        for value, colour in plot.limits
    )
    goes = f' onclick="{escape(_goes(slider))}"' if slider else ""
    cursor = '<i class="wb-at"></i>' if slider else ""
    return (
        f'<div class="wb-plot"><div class="wb-plot-title"><span>{escape(plot.title)}</span> '
        f"[{escape(plot.unit)}]</div>"
        f'<div class="wb-canvas"{goes}>{across}'
        f'<svg viewBox="0 0 {PLOT_WIDTH:g} {PLOT_HEIGHT:g}" preserveAspectRatio="none" '
        f'aria-hidden="true">'
        f"{lines}</svg>{cursor}</div>{_along(begin, end, plot.along)}</div>"
    )


def legend_html(plot: Plot, time: float | None = None) -> str:
    """The names of the curves, with their values at a time [s]."""

    def value(curve: Curve) -> str:
        return "" if time is None else f" <b>{_format(_at(plot.times, curve.values, time))}</b>"

    entries = "".join(
        f'<span class="wb-leg"><i style="background:{curve.colour}"></i>{escape(curve.name)}'
        f"{value(curve)}</span>"
        for curve in plot.curves
    )
    return f'<div class="wb-legend wb-values">{entries}</div>'


def cursor_style(time: float, seconds: float) -> str:
    """The style that puts the cursors of all plots at a time [s]."""
    share = _share(time, 0.0, seconds) if seconds > 0 else 0.0
    # Not a variable of the whole page: then all of it would be styled anew for each picture.
    return f'<style class="wb-style">i.wb-at{{left:{share:.2f}%}}</style>'


def _line(
    times: Floats, curve: Curve, bounds: tuple[float, float], along: tuple[float, float]
) -> str:
    (low, high), (begin, end) = bounds, along
    x = PLOT_WIDTH * (times - begin) / max(end - begin, 1e-9)
    y = PLOT_HEIGHT * (high - curve.values) / (high - low)
    drawn = drawn_samples(y)
    x, y = x[drawn], y[drawn]
    pieces: list[str] = []
    is_down = False
    for across, down in zip(x.tolist(), y.tolist(), strict=True):
        if not math.isfinite(down):
            is_down = False
            continue
        pieces.append(f"{'L' if is_down else 'M'}{across:.1f} {down:.1f}")
        is_down = True
    return f'<path d="{"".join(pieces)}" stroke="{curve.colour}"/>'


def drawn_samples(values: Floats) -> np.ndarray:
    """Which samples of a curve are drawn, so that a long session's curve is as quick as a short's.

    Args:
        values: (k,) in any unit; NaN where the curve has none.

    Returns:
        (n,) indices, ascending: all of a short curve; of a long one the lowest and the highest
        sample of each of `MOST_COLUMNS` columns, the first where a column has no value.
    """
    if len(values) <= 2 * MOST_COLUMNS:
        return np.arange(len(values))
    ends = np.linspace(0, len(values), MOST_COLUMNS + 1).astype(np.int64)
    chosen: set[int] = set()
    for begin, end in pairwise(ends.tolist()):
        column = values[begin:end]
        if np.isnan(column).all():
            chosen.add(begin)
        else:
            chosen |= {begin + int(np.nanargmin(column)), begin + int(np.nanargmax(column))}
    return np.array(sorted(chosen))


def _along(begin: float, end: float, unit: str) -> str:
    every = ticks(begin, max(end, begin + 1e-3), is_whole=unit in COUNTED)
    marks = [f'<b style="{_place_along(_share(tick, begin, end))}">{tick:g}</b>' for tick in every]
    # The unit stands behind the last number, where it lies over none.
    marks[-1] = marks[-1].removesuffix("</b>") + f"<span> {escape(unit)}</span></b>"
    return f'<div class="wb-times">{"".join(marks)}</div>'


def _place_along(share: float) -> str:
    """The style of a number at a share [%] of the axis: centred there, at its end before it."""
    if share > MOST_ALONG:
        return "left:auto;right:0;transform:none"
    return f"left:{share:.2f}%"


def _share(value: float, low: float, high: float) -> float:
    return 100 * min(max((value - low) / max(high - low, 1e-9), 0.0), 1.0)


def _at(times: Floats, values: Floats, time: float) -> float:
    """The value that holds at a time: of the sample before, as bounds go in steps."""
    place = int(np.searchsorted(times, time, side="right")) - 1
    return float(values[min(max(place, 0), len(values) - 1)])


def _format(value: float) -> str:
    return f"{value:.1f}" if math.isfinite(value) else "-"


def _goes(slider: str) -> str:
    """What a click does: as if one had pressed there on the slider, which spans the plan."""
    return (
        f"const b=this.getBoundingClientRect(),s=document.getElementById('{slider}'),"
        "r=s.getBoundingClientRect(),x=r.left+r.width*(event.clientX-b.left)/b.width,"
        "on=s.querySelector('.mantine-Slider-trackContainer');"
        "for(const t of ['mousedown','mouseup'])on.dispatchEvent(new MouseEvent(t,"
        "{bubbles:true,cancelable:true,clientX:x,clientY:r.top+r.height/2}))"
    )

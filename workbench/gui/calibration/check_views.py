"""What the page says of trueness and touch test, as HTML."""

from collections.abc import Sequence
from html import escape

import numpy as np

from workbench.app.core.state import State
from workbench.gui.shared.calibration_views import light_html
from workbench.gui.shared.views import line, mm, sentence, table_html
from workbench.gui.texts.calibration import CalibrationText
from workbench.model.calibration import BallScan
from workbench.model.derived.touches import touched_ball
from workbench.model.errors import InputError
from workbench.perception.calibration.touch_test import assess_touches
from workbench.perception.calibration.trueness import assess_trueness
from workbench.words.words import IN_ENGLISH, Words


def trueness_html(scans: Sequence[BallScan], limit: float, words: Words = IN_ENGLISH) -> str:
    """The verdict of all scans, its figures, and a row for each distance; `limit` [m]."""
    if not scans:
        return line("No scan of the balls yet. Three places are advised.", kind="hint")
    found = assess_trueness(scans, limit)
    share, error = f"{found.scale * 100:+.3f}", f"{found.scale_error * 100:.3f}"
    scale = CalibrationText.SCALE(share=share, error=error)
    if not np.isfinite(found.scale_error):
        scale = CalibrationText.SCALE_OPEN(share=share)
    facts = [
        ("Sphere-spacing error", CalibrationText.SPACING(off=found.largest, limit=limit)),
        ("Scale error", scale),
        ("Probing size error", CalibrationText.SIZE(size=found.size)),
        ("Probing form error", CalibrationText.FORM(form=found.form)),
    ]
    rows = [
        (scan.name, mm(stated, 3), mm(measured, 3), f"{(measured - stated) * 1000:+.3f} mm")
        for scan in scans
        for stated, measured in zip(scan.artefact.lengths, scan.measured, strict=True)
    ]
    verdict = light_html(found.light, f"{sentence(words.render(found.says))}.")
    table = table_html([(name, words.render(fact)) for name, fact in facts])
    return verdict + table + _rows_html(("Scan",), ("Stated", "Measured", "Error"), rows)


def touches_html(state: State, words: Words = IN_ENGLISH) -> str:
    """The verdict of all touches, which part of the offsets is common, and a row for each touch."""
    cell, scans, touches = state.cell, state.ball_scans, state.touches
    if not touches:
        return line("No touch yet. Three balls or more are needed.", kind="hint")
    by_name = {scan.name: scan for scan in scans}
    try:
        balls = [touched_ball(cell, by_name[touch.scan], touch) for touch in touches]
    except InputError as error:
        return light_html("bad", f"{sentence(words.render(error.message))}.")
    rows = [
        (touch.name, touch.scan, str(ball.ball), mm(float(np.linalg.norm(ball.offset)), 2))
        for touch, ball in zip(touches, balls, strict=True)
    ]
    table = _rows_html(("Touch", "Scan", "Ball"), ("Off",), rows)
    try:
        found = assess_touches(cell, scans, touches, state.check_limits[1] or None)
    except InputError as error:
        return light_html("warning", f"{sentence(words.render(error.message))}.") + table
    x, y, z = (f"{value * 1000:+.2f}" for value in found.mean)
    shift = {"shift": found.found.shift, "bound": found.allowed.shift, "x": x, "y": y, "z": z}
    facts = [
        ("Common shift", CalibrationText.SHIFT(**shift)),
        (
            "From touch to touch",
            CalibrationText.REST(rest=found.found.rest, bound=found.allowed.rest),
        ),
    ]
    verdict = light_html(found.light, f"{sentence(words.render(found.says))}.")
    return verdict + table_html([(name, words.render(fact)) for name, fact in facts]) + table


def _rows_html(
    names: tuple[str, ...], numbers: tuple[str, ...], rows: Sequence[tuple[str, ...]]
) -> str:
    """A table: columns of names, then of numbers, which stand on the right."""
    kinds = [""] * len(names) + [' class="wb-number"'] * len(numbers)

    def row_html(cells: tuple[str, ...], tag: str) -> str:
        pairs = zip(kinds, cells, strict=True)
        return f"<tr>{''.join(f'<{tag}{kind}>{escape(cell)}</{tag}>' for kind, cell in pairs)}</tr>"

    body = "".join(row_html(row, "td") for row in rows)
    return (
        '<div class="wb-rows"><table class="wb-table"><thead>'
        f"{row_html((*names, *numbers), 'th')}</thead><tbody>{body}</tbody></table></div>"
    )

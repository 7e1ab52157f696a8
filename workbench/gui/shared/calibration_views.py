"""What the page says about calibration and bin, as text and HTML; see `views` for how."""

from collections.abc import Sequence
from html import escape

import numpy as np

from workbench.app.calibration.calibration import corner_errors, moved_by
from workbench.app.core.state import State
from workbench.gui.shared.calibrating import CLOSE, OFF, Overlay
from workbench.gui.shared.colours import BAD, BUSY, GOOD, MUTED
from workbench.gui.shared.tables import clickable, marked
from workbench.gui.shared.views import day_and_time, line, mm, sentence, table_html
from workbench.model.calibration import (
    BinCheck,
    Calibration,
    Light,
    NextPose,
    PlateObservation,
    PoseResidual,
)
from workbench.model.cell import Cell

DAY = 24 * 3600.0

LIGHTS: dict[Light, str] = {"good": GOOD, "warning": BUSY, "bad": BAD}

ADVISED = 8

CORNERS = ("Front left", "Front right", "Back left", "Back right")


def days_old(cell: Cell, now: float) -> float | None:
    """How old the calibration is; None when there is none."""
    record = cell.scanner.calibration
    return None if record is None else max(0.0, (now - record.at) / DAY)


def calibration_warning(cell: Cell, now: float) -> str:
    """What is to be said against the scanner's pose; empty when nothing."""
    old = days_old(cell, now)
    if old is None:
        # A made-up scanner hangs where the cell says, and a merged one takes no view without it.
        is_real = cell.scanner.source not in ("simulated", "merged")
        return "the scanner's pose was never calibrated" if is_real else ""
    if old > cell.scanner.calibration_days:
        limit = cell.scanner.calibration_days
        return f"the scanner was calibrated {old:.0f} days ago; {limit:g} are allowed"
    return ""


def record_line(cell: Cell, now: float) -> str:
    """Who has calibrated the scanner of the cell, when, and how well."""
    record = cell.scanner.calibration
    if record is None:
        return line("Not calibrated: the pose is as somebody has written or moved it.", kind="hint")
    on = day_and_time(record.at)
    said = f"Calibrated {on} by {record.by}: {record.poses} poses, {mm(record.rms, 2)} RMS."
    if record.covariance is not None:
        largest = max(corner_errors(cell, record.covariance).values())
        said += f" What lies at the bin's corners is seen to {mm(largest, 2)} (95%)."
    warning = calibration_warning(cell, now)
    if warning:
        return line(f"{said} {sentence(warning)}.", kind="bad")
    return line(said)


def light_html(light: Light, text: str) -> str:
    """A traffic light and what it says."""
    return (
        f'<div class="wb-light wb-span3" data-light="{light}" title="{escape(text)}">'
        f'<i style="background:{LIGHTS[light]}"></i><span>{escape(text)}</span></div>'
    )


def bin_html(state: State, check: BinCheck | None, now: float) -> str:
    """What the scan says about the bin, and what is to be said against the scanner's pose."""
    warning = calibration_warning(state.cell, now)
    if check is None:
        return light_html("warning", f"{sentence(warning)}.") if warning else ""
    said = f"{sentence(str(check.says))}."
    light: Light = check.light
    if warning:
        said, light = f"{said} {sentence(warning)}.", "warning" if light == "good" else light
    return light_html(light, said)


def poses_html(
    observations: Sequence[PlateObservation],
    found: Calibration | str,
    chosen: int | None,
    rows: Sequence[str],
) -> str:
    """A row for each pose: its residuals, its light, and why it does not count."""
    if not observations:
        return line("No pose yet. Eight are advised, four are needed.", kind="hint")
    residuals: Sequence[PoseResidual | None] = [None] * len(observations)
    if isinstance(found, Calibration):
        residuals = found.residuals
    body = "".join(
        _pose_row(observation, residual, number == chosen, rows[number])
        for number, (observation, residual) in enumerate(
            zip(observations[: len(rows)], residuals, strict=False)
        )
    )
    return (
        '<div class="wb-rows wb-poses"><table class="wb-table"><thead><tr><th>Pose</th>'
        '<th class="wb-number">Off</th><th class="wb-number">Turned</th>'
        '<th class="wb-number" title="How far it is from where the other poses alone predict it.">'
        "By the others</th><th>Counts</th>"
        f"</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _pose_row(
    observation: PlateObservation, residual: PoseResidual | None, is_chosen: bool, button: str
) -> str:
    distance = angle = predicted = ""
    says, colour = "yes" if observation.is_used else "left out by a person", MUTED
    if residual is not None:
        distance, angle = mm(residual.distance, 2), f"{np.rad2deg(residual.angle):.2f}°"
        predicted = "open" if residual.predicted is None else _off(residual.predicted)
        colour = LIGHTS[residual.light]
        says = str(residual.left_out or "yes")
    dot = f'<span class="wb-verdict" style="background:{colour}">{escape(observation.name)}</span>'
    return (
        f'<tr{marked(is_chosen)} title="{escape(says)}" {clickable(button)}><td>{dot}</td>'
        f'<td class="wb-number">{escape(distance)}</td><td class="wb-number">{escape(angle)}</td>'
        f'<td class="wb-number">{escape(predicted)}</td><td>{escape(says)}</td></tr>'
    )


def _off(shift_and_turn: tuple[float, float]) -> str:
    return f"{mm(shift_and_turn[0], 2)}, {np.rad2deg(shift_and_turn[1]):.2f}°"


def answer_html(cell: Cell, found: Calibration | str, count: int) -> str:
    """Before and after, and how sure it is; or why there is no answer yet."""
    if isinstance(found, str):
        return line(f"{sentence(found)}.", kind="bad") if count else ""
    distance, angle, shift = moved_by(cell, found)
    rows = [
        (
            "The scanner is",
            f"{mm(distance)} and {np.rad2deg(angle):.2f}° from where the cell has it",
        ),
        ("In the bin", f"what is found moves by {mm(shift)}"),
        ("Poses agree to", f"{mm(found.rms, 2)} RMS, {found.used} used"),
        ("Predicted by the others", _prediction_words(found)),
        (
            "Sure to",
            f"{mm(found.position_error, 2)} and {np.rad2deg(found.angle_error):.3f}° (standard "
            "errors)",
        ),
    ]
    more = f"{ADVISED} poses are better than {found.used}." if found.used < ADVISED else ""
    return table_html(rows) + corners_html(cell, found) + (line(more, kind="hint") if more else "")


def _prediction_words(found: Calibration) -> str:
    """Each pose by those without it."""
    worst, rms = found.worst_predicted, found.predicted_rms
    if worst is None or worst.predicted is None:
        return "the poses are too few to predict any"
    said = f"the worst is {worst.name}: {_off(worst.predicted)}"
    return f"{_off(rms)} RMS; {said}" if rms is not None else f"not all; {said}"


def corners_html(cell: Cell, found: Calibration) -> str:
    """How far off the bin's corners are seen by what the calibration leaves open."""
    errors = corner_errors(cell, found.covariance, found.T_world_scanner)
    largest = max(errors.values())
    said = (
        f"What lies at the corners of the bin is seen to {mm(largest, 2)} or better in 95% "
        "of such calibrations. Robot and search come on top."
    )
    body = "".join(
        f"<tr><td>{escape(name)}</td>"
        f'<td class="wb-number">{mm(errors[f"floor {name.lower()}"], 2)}</td>'
        f'<td class="wb-number">{mm(errors[f"rim {name.lower()}"], 2)}</td></tr>'
        for name in CORNERS
    )
    return (
        f'{line(said)}<div class="wb-rows wb-corners"><table class="wb-table"><thead><tr>'
        '<th>Corner</th><th class="wb-number">Floor</th><th class="wb-number">Rim</th></tr>'
        f"</thead><tbody>{body}</tbody></table></div>"
    )


def next_html(pose: NextPose) -> str:
    """How the plate gets to a suggested pose, and what that would bring."""
    steps = "".join(
        line(f"{number}. {sentence(str(step))}") for number, step in enumerate(pose.steps, 1)
    )
    return (
        line(f"From {pose.after} on, with the plate as it is held:")
        + steps
        + line(
            f"The worst corner of the bin would be seen to {mm(pose.error_with, 2)} "
            f"instead of {mm(pose.error, 2)}."
        )
    )


def overlay_line(shown: Overlay | None) -> str:
    """What the colours over the robot mean, and how well it lies there."""
    if shown is None:
        return line("Choose a pose to see its scan over the robot.", kind="hint")
    middle = "none" if shown.middle is None else f"in the middle {mm(shown.middle)} away"
    return line(
        f"Points near the robot: {middle}; "
        f"green to {mm(CLOSE, 0)}, amber to {mm(OFF, 0)}, red beyond."
    )

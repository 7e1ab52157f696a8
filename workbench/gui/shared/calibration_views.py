"""What the page says about calibration and bin, as text and HTML; see `views` for how."""

from collections.abc import Sequence
from html import escape

import numpy as np

from workbench.app.calibration.calibration import corner_errors, moved_by
from workbench.app.core.state import State
from workbench.gui.shared.calibrating import AMBER_WITHIN, GREEN_WITHIN, Overlay
from workbench.gui.shared.colours import BAD, BUSY, GOOD, MUTED, badge
from workbench.gui.shared.tables import clickable, mark_attribute
from workbench.gui.shared.views import day_and_time, line, mm, sentence, table_html
from workbench.gui.texts.calibration import CalibrationText
from workbench.model.calibration import (
    BinCheck,
    Calibration,
    Light,
    NextPose,
    PlateObservation,
    PoseResidual,
)
from workbench.model.cell import Cell
from workbench.model.derived.scanner_poses import calibration_covariance
from workbench.model.messages.calibration import PlateText
from workbench.model.messages.message import Message, as_message
from workbench.words.words import IN_ENGLISH, Words

DAY = 24 * 3600.0

LIGHTS: dict[Light, str] = {"good": GOOD, "warning": BUSY, "bad": BAD}

ADVISED = 8

CORNERS = ("Front left", "Front right", "Back left", "Back right")


def days_old(cell: Cell, now: float) -> float | None:
    """How old the calibration is; None when there is none."""
    record = cell.scanner.calibration
    return None if record is None else max(0.0, (now - record.at) / DAY)


def calibration_warning(cell: Cell, now: float) -> Message | None:
    """What is to be said against the scanner's pose; None when nothing."""
    old = days_old(cell, now)
    if old is None:
        # A made-up scanner hangs where the cell says, and a merged one takes no view without it.
        is_real = cell.scanner.source not in ("simulated", "merged")
        return CalibrationText.NEVER() if is_real else None
    if old > cell.scanner.calibration_days:
        limit = f"{cell.scanner.calibration_days:g}"
        return CalibrationText.OLD(days=round(old), limit=limit)
    return None


def record_line(cell: Cell, now: float, words: Words = IN_ENGLISH) -> str:
    """Who has calibrated the scanner of the cell, when, and how well."""
    record = cell.scanner.calibration
    if record is None:
        return line("Not calibrated: the pose was entered by hand.", kind="hint")
    at = day_and_time(record.at)
    texts = [CalibrationText.RECORD(at=at, person=record.by, count=record.poses, rms=record.rms)]
    covariance = calibration_covariance(cell.scanner)
    if covariance is not None:
        largest = max(corner_errors(cell, covariance).values())
        texts.append(CalibrationText.RECORD_CORNERS(error=largest))
    warning = calibration_warning(cell, now)
    if warning is not None:
        texts.append(warning)
    kind = "result" if warning is None else "bad"
    return line(" ".join(map(words.render, texts)), kind=kind)


def light_html(light: Light, text: str) -> str:
    """A traffic light and what it says."""
    return (
        f'<div class="wb-light wb-span3" data-light="{light}" title="{escape(text)}">'
        f'<i style="background:{LIGHTS[light]}"></i><span>{escape(text)}</span></div>'
    )


def bin_html(state: State, check: BinCheck | None, now: float, words: Words = IN_ENGLISH) -> str:
    """What the scan says about the bin, and what is to be said against the scanner's pose."""
    warning = calibration_warning(state.cell, now)
    if check is None:
        return light_html("warning", words.render(warning)) if warning is not None else ""
    text = f"{sentence(words.render(check.says))}."
    light: Light = check.light
    if warning is not None:
        text = f"{text} {words.render(warning)}"
        light = "warning" if light == "good" else light
    return light_html(light, text)


def poses_html(
    observations: Sequence[PlateObservation],
    found: Calibration | Message | str,
    chosen: int | None,
    rows: Sequence[str],
    words: Words = IN_ENGLISH,
) -> str:
    """A row for each pose: its residuals, its light, and why it does not count."""
    if not observations:
        return line("No pose yet. Eight are advised, four are needed.", kind="hint")
    residuals: Sequence[PoseResidual | None] = [None] * len(observations)
    if isinstance(found, Calibration):
        residuals = found.residuals
    body = "".join(
        _pose_row(observation, residual, number == chosen, rows[number], words)
        for number, (observation, residual) in enumerate(
            zip(observations[: len(rows)], residuals, strict=False)
        )
    )
    return (
        '<div class="wb-rows wb-poses"><table class="wb-table"><thead><tr><th>Pose</th>'
        '<th class="wb-number" title="How far the plate is from where all poses together put it.">'
        'Residual [mm]</th><th class="wb-number" '
        'title="How much the plate is turned from how all poses together put it.">'
        'Residual [deg]</th><th class="wb-number" '
        'title="How far it is from where the other poses alone predict it.">'
        "Cross-check [mm, deg]</th><th>Counts</th>"
        f"</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _pose_row(
    observation: PlateObservation,
    residual: PoseResidual | None,
    is_chosen: bool,
    button: str,
    words: Words,
) -> str:
    distance = angle = predicted = ""
    says, colour = "yes" if observation.is_used else "left out by a person", MUTED
    if residual is not None:
        distance, angle = _millimetres(residual.distance), _degrees(residual.angle)
        predicted = "open"
        if residual.predicted is not None:
            shift, turn = residual.predicted
            predicted = f"{_millimetres(shift)}, {_degrees(turn)}"
        colour = LIGHTS[residual.light]
        says = words.render(residual.left_out) or "yes"
    dot = badge(colour, observation.name)
    return (
        f'<tr{mark_attribute(is_chosen)} title="{escape(says)}" {clickable(button)}><td>{dot}</td>'
        f'<td class="wb-number">{escape(distance)}</td><td class="wb-number">{escape(angle)}</td>'
        f'<td class="wb-number">{escape(predicted)}</td><td>{escape(says)}</td></tr>'
    )


def _millimetres(length: float) -> str:
    """A length [m] in the unit of the column's head."""
    return f"{length * 1000:.2f}"


def _degrees(angle: float) -> str:
    """An angle [rad] in the unit of the column's head."""
    return f"{np.rad2deg(angle):.2f}"


def _off(shift_and_turn: tuple[float, float]) -> Message:
    return CalibrationText.OFF(shift=shift_and_turn[0], turn=shift_and_turn[1])


def answer_html(
    cell: Cell, found: Calibration | Message | str, count: int, words: Words = IN_ENGLISH
) -> str:
    """Before and after, and the standard errors; or why there is no answer yet."""
    if not isinstance(found, Calibration):
        if not count:
            return ""
        # Too few poses are what a calibration begins with, and no failure.
        if isinstance(found, Message) and found.text is PlateText.TOO_FEW_POSES:
            return line(words.render(CalibrationText.PROGRESS(**found.args)), kind="hint")
        return line(f"{sentence(words.render(found))}.", kind="bad")
    distance, angle, shift = moved_by(cell, found)
    errors = CalibrationText.STANDARD_ERRORS(position=found.position_error, angle=found.angle_error)
    agreement = CalibrationText.AGREEMENT(rms=found.rms, count=found.used)
    facts = [
        ("The scanner is", CalibrationText.MOVED(shift=distance, turn=angle)),
        ("In the bin", CalibrationText.FINDINGS_MOVE(shift=shift)),
        ("Poses agree to", agreement),
        ("Predicted by the others", _prediction_message(found)),
        ("Uncertainty", errors),
    ]
    table = table_html([(name, words.render(fact)) for name, fact in facts])
    more = CalibrationText.MORE_POSES(advised=ADVISED, used=found.used)
    advice = line(words.render(more), kind="hint") if found.used < ADVISED else ""
    return table + corners_html(cell, found, words) + advice


def _prediction_message(found: Calibration) -> Message | str:
    """Each pose by those without it."""
    worst, rms = found.worst_predicted, found.predicted_rms
    if worst is None or worst.predicted is None:
        return "the poses are too few to predict any"
    named = CalibrationText.WORST(name=worst.name, off=_off(worst.predicted))
    if rms is None:
        return CalibrationText.SOME_PREDICTED(worst=named)
    return CalibrationText.PREDICTED(rms=_off(rms), worst=named)


def corners_html(cell: Cell, found: Calibration, words: Words = IN_ENGLISH) -> str:
    """How far off the bin's corners are seen by what the calibration leaves open."""
    errors = corner_errors(cell, found.covariance, found.T_world_scanner)
    largest = max(errors.values())
    said = words.render(CalibrationText.CORNERS(error=largest))
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


def next_html(pose: NextPose, *, is_carried: bool, words: Words = IN_ENGLISH) -> str:
    """How the plate, or the scanner that is carried, gets to a pose, and what that would bring."""
    begins = CalibrationText.SCANNER_FROM if is_carried else CalibrationText.NEXT_FROM
    texts = (
        begins(pose=pose.after),
        *(
            CalibrationText.NEXT_STEP(number=number, step=as_message(step))
            for number, step in enumerate(pose.steps, 1)
        ),
        CalibrationText.NEXT_GAIN(after=pose.error_with, before=pose.error),
    )
    return "".join(line(words.render(text)) for text in texts)


def overlay_line(shown: Overlay | None, *, is_carried: bool, words: Words = IN_ENGLISH) -> str:
    """What the colours over robot or whole cell mean, and how well the scan lies there."""
    if shown is None:
        over_cell = "Choose a pose to see its scan over the cell."
        over_robot = "Choose a pose to see its scan over the robot."
        return line(over_cell if is_carried else over_robot, kind="hint")
    middle = CalibrationText.OVERLAY_NONE()
    if shown.middle is not None:
        middle = CalibrationText.OVERLAY_MIDDLE(distance=shown.middle)
    over = CalibrationText.OVERLAY_CELL if is_carried else CalibrationText.OVERLAY
    return line(words.render(over(middle=middle, close=GREEN_WITHIN, off=AMBER_WITHIN)))

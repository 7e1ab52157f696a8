"""What a calibration found, as tables and as JSON."""

import numpy as np
import pinocchio as pin

from workbench.app.calibration.calibration import corner_errors, moved_by
from workbench.cli.terminal import print_table
from workbench.model.calibration import Calibration
from workbench.model.cell import Cell
from workbench.model.derived.scanner_poses import flange_at_view
from workbench.model.geometry import Floats, shift_and_turn

ADVISED = 8


def in_flange(cell: Cell, calibration: Calibration) -> pin.SE3 | None:
    """`T_flange_scanner` of a scanner on an arm; None where it stands."""
    if cell.scanner.on_arm is None:
        return None
    return flange_at_view(cell.scanner).actInv(calibration.T_world_scanner)


def print_poses(calibration: Calibration, T_flange_scanner: pin.SE3 | None) -> None:
    """Print how well each pose fits, and where the scanner is: in the flange or in the world."""
    rows = (
        (
            residual.name,
            f"{residual.distance * 1000:.2f}",
            f"{np.rad2deg(residual.angle):.2f}",
            *_format_prediction(residual.predicted),
            residual.light if not residual.left_out else "left out",
            str(residual.left_out or ""),
        )
        for residual in calibration.residuals
    )
    print_table(
        f"{calibration.used} poses, {calibration.rms * 1000:.2f} mm RMS",
        ("pose", "off mm", "off deg", "others mm", "others deg", "light", "why"),
        rows,
    )
    worst, all_of_them = calibration.worst_predicted, calibration.predicted_rms
    if worst is not None and all_of_them is not None:
        print(
            "others: each pose as all the others predict it, "
            f"{' mm, '.join(_format_prediction(all_of_them))} degrees RMS; "
            f"the worst is {worst.name}, "
            f"{' mm, '.join(_format_prediction(worst.predicted))} degrees"
        )
    T = calibration.T_world_scanner if T_flange_scanner is None else T_flange_scanner
    rpy = np.rad2deg(pin.rpy.matrixToRpy(T.rotation))
    if T_flange_scanner is not None:
        print("the robot carries the scanner: its pose below is that in the flange")
    print(f"position_mm = {format_numbers(T.translation * 1000, 2)}")
    print(f"rpy_deg = {format_numbers(rpy, 3)}")
    print(
        f"sure to {calibration.position_error * 1000:.2f} mm and "
        f"{np.rad2deg(calibration.angle_error):.3f} degrees (standard errors, worst direction)"
    )
    if calibration.used < ADVISED:
        print(f"{ADVISED} poses are better than {calibration.used}")


def print_in_cell(cell: Cell, calibration: Calibration) -> None:
    """Print what that means for what lies in the bin, and how far it is from what the cell has."""
    T = calibration.T_world_scanner
    errors = corner_errors(cell, calibration.covariance, T)
    print_table(
        f"what lies at the corners of the bin is seen to {max(errors.values()) * 1000:.2f} mm or "
        "better in 95% of such calibrations",
        ("corner", "mm"),
        ((name, f"{error * 1000:.2f}") for name, error in errors.items()),
    )
    before = cell.scanner.T_world_scanner.actInv(T)
    shift = moved_by(cell, calibration)[2]
    print(
        f"from where the cell has it: {words_of_motion(before)}; what lies in the bin moves by "
        f"{shift * 1000:.2f} mm"
    )


def poses_form(calibration: Calibration) -> dict[str, object]:
    """What `--json` gives of the poses and of how sure the result is."""
    return {
        "ok": True,
        "poses": [
            {
                "name": residual.name,
                "off_mm": round(residual.distance * 1000, 4),
                "off_deg": round(float(np.rad2deg(residual.angle)), 4),
                "predicted_mm": _round(residual.predicted, 0),
                "predicted_deg": _round(residual.predicted, 1),
                "light": residual.light,
                "left_out": residual.left_out,
            }
            for residual in calibration.residuals
        ],
        "rms_mm": round(calibration.rms * 1000, 4),
        "position_error_mm": round(calibration.position_error * 1000, 4),
        "angle_error_deg": round(float(np.rad2deg(calibration.angle_error)), 5),
        "predicted_rms_mm": _round(calibration.predicted_rms, 0),
        "predicted_rms_deg": _round(calibration.predicted_rms, 1),
        "covariance": calibration.covariance.tolist(),
    }


def in_cell_form(cell: Cell, calibration: Calibration) -> dict[str, object]:
    """What `--json` gives of the scanner in the cell."""
    distance, angle, shift = moved_by(cell, calibration)
    errors = corner_errors(cell, calibration.covariance, calibration.T_world_scanner)
    T_flange_scanner = in_flange(cell, calibration)
    form: dict[str, object] = {
        "T_world_scanner": _rows(calibration.T_world_scanner),
        "corners_mm": {name: round(error * 1000, 4) for name, error in errors.items()},
        "largest_corner_mm": round(max(errors.values()) * 1000, 4),
        "moved_mm": round(distance * 1000, 4),
        "moved_deg": round(float(np.rad2deg(angle)), 5),
        "moved_in_bin_mm": round(shift * 1000, 4),
    }
    if T_flange_scanner is not None:
        form["T_flange_scanner"] = _rows(T_flange_scanner)
    return form


def _format_prediction(off: tuple[float, float] | None) -> tuple[str, str]:
    """In mm and degrees; the others may leave a pose open."""
    if off is None:
        return "open", "open"
    return f"{off[0] * 1000:.2f}", f"{np.rad2deg(off[1]):.2f}"


def _rows(T: pin.SE3) -> list[list[float]]:
    return T.homogeneous.tolist()


def _round(off: tuple[float, float] | None, which: int) -> float | None:
    """In mm (0) or degrees (1)."""
    if off is None:
        return None
    return round(float((off[0] * 1000, np.rad2deg(off[1]))[which]), 4)


def words_of_motion(T: pin.SE3) -> str:
    """A motion for people."""
    distance, angle = shift_and_turn(T)
    return f"{distance * 1000:.2f} mm and {np.rad2deg(angle):.3f} degrees"


def format_numbers(values: Floats, digits: int) -> str:
    """Numbers (n,), no unit of their own, as a cell file has them."""
    return f"[{', '.join(f'{value + 0.0:.{digits}f}' for value in values)}]"

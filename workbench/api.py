"""What programs use of the workbench: `import workbench` offers all of it, and nothing else.

The values are those that the page uses: frozen, SI units and radians, poses as Pinocchio's SE3.
Whatever is compiled for its first use makes the first call of `localize` or `plan` on a machine
take about a minute; `workbench compile` does that ahead.
"""

import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import pinocchio as pin

from workbench.app.calibration import ball_plate
from workbench.app.calibration import calibration as calibrations
from workbench.app.calibration.calibration import with_calibration
from workbench.app.core.command import Entry
from workbench.app.core.cycle import approval
from workbench.app.core.state import State
from workbench.app.filling.fill import Filled, filled
from workbench.app.picking.judging import judge
from workbench.app.picking.proving import prove
from workbench.app.picking.row import plan_row
from workbench.app.records import case_folder, session_archive
from workbench.app.records import replay as replays
from workbench.app.records.cases import Case, read_case
from workbench.app.records.sessions import cell_of
from workbench.app.runtime.compiled_code import forget_the_old, take_shipped
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_scan, write_cloud
from workbench.formats.parts.reading import read_part
from workbench.formats.plans import plan_files
from workbench.formats.plans.plan_files import write_plan
from workbench.formats.plans.pose_files import read_poses, write_poses
from workbench.journal.journal import Journal
from workbench.model.calibration import BallPlate, Calibration, PlateObservation
from workbench.model.candidate import Candidate, Verdict
from workbench.model.cell import Cell, PlanOverrides
from workbench.model.derived.by_recipe import wanted_parts
from workbench.model.digest import digest_of
from workbench.model.errors import (
    CommandRefused,
    FileError,
    InputError,
    JournalError,
    LinkError,
    WorkbenchError,
)
from workbench.model.geometry import Floats
from workbench.model.part import Grasp, GraspLibrary, Part
from workbench.model.plan import Plan, PlanResult, Proof
from workbench.model.release import Approval, Receipt
from workbench.model.scan import Detection, LocalizationResult, Obstacle, Scan, Unexplained
from workbench.perception.calibration.balls import sight_plate
from workbench.perception.scene.unexplained import look_around, unexplained
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.planning.grasps.grasp_suggestions import suggest
from workbench.planning.picking.nearest_fix import Fix, nearest_fix
from workbench.plugins.localizer import find_parts
from workbench.plugins.robot_link import send

__all__ = [
    "Approval",
    "BallPlate",
    "Calibration",
    "Candidate",
    "Case",
    "Cell",
    "CommandRefused",
    "Detection",
    "Entry",
    "FileError",
    "Filled",
    "Fix",
    "Grasp",
    "GraspLibrary",
    "InputError",
    "Journal",
    "JournalError",
    "LinkError",
    "LocalizationResult",
    "Obstacle",
    "Part",
    "Plan",
    "PlanOverrides",
    "PlanResult",
    "PlateObservation",
    "Proof",
    "Receipt",
    "Scan",
    "State",
    "Verdict",
    "WorkbenchError",
    "approve",
    "calibrate",
    "corner_errors",
    "drop_parts",
    "filled",
    "judge",
    "localize",
    "nearest_fix",
    "open_session",
    "plan",
    "plate_poses",
    "prove",
    "read_case",
    "read_cell",
    "read_part",
    "read_plan",
    "read_poses",
    "read_scan",
    "replay",
    "send",
    "session_cases",
    "sight_plate",
    "simulate_plate",
    "simulate_scan",
    "suggest",
    "unexplained",
    "with_calibration",
    "write_cloud",
    "write_plan",
    "write_poses",
]


# Scripts come here without a command that makes ready: they must not run what was compiled from the
# sources before an update, and take what was compiled ahead.
forget_the_old()
take_shipped()


def simulate_scan(cell: Cell, truth: Sequence[Detection], *, seed: int = 0) -> Scan:
    """What the scanner of a cell would see of parts that lie as they are given.

    Args:
        cell: with its scanner, bin and fixtures; the robot is out of the picture.
        truth: the parts, for example from `drop_parts`.
        seed: of the scanner's noise.
    """
    return synthesize(cell, truth, seed=seed)


def localize(cell: Cell, scan: Scan, *, seed: int = 0, detail: float = 1.0) -> LocalizationResult:
    """All parts of a cell that are seen in a scan, the surest first.

    Args:
        cell: whose parts are searched for.
        scan: of its scanner.
        seed: the same seed finds the same.
        detail: more than 1 looks more closely and takes longer, less than 1 less.
    """
    return find_parts(scan, cell, seed=seed, detail=detail)


def plan(
    cell: Cell,
    detections: Sequence[Detection],
    *,
    scan: Scan | None = None,
    strategy: str = "auto",
    threshold: float | None = None,
    overrides: PlanOverrides | None = None,
    seed: int = 0,
) -> PlanResult:
    """Judge every grasp of every part, plan for the best, and prove the plan.

    Args:
        cell: with its arms, places and policy.
        detections: the parts in the bin, at least one; those not taken are obstacles.  By a
            recipe that fills kits, those of an empty kit may be taken.
        scan: in which they were found; what else it shows within reach is avoided, and where that
            may go on unseen wherever there is a plan that can; the plan's note says where none can.
        strategy: `auto`, `alternated`, `coordinated`, `both`, or the name of
            an arm, which works alone.
        threshold: [m] nearer parts are taken by one arm after the other; None takes the cell's.
        overrides: what this one planning wants otherwise than the cell's policy.
        seed: the same seed gives the same plan.

    Returns:
        All candidates with their verdicts, and the plan with its proof, or why there is none.

    Raises:
        InputError: there are no detections, or the strategy is not one.
    """
    found = tuple(detections)
    around = Unexplained() if scan is None else look_around(cell, scan, found)
    return plan_row(
        cell,
        found,
        digest_of(found) if scan is None else scan.digest,
        strategy=strategy,
        threshold=threshold,
        overrides=PlanOverrides() if overrides is None else overrides,
        obstacles=around.seen,
        unseen=around.unseen,
        wanted=wanted_parts(cell),
        seed=seed,
    )


def read_plan(path: str) -> Plan:
    """A plan from its file.

    Raises:
        FileError: it cannot be read, is no plan, or was changed after it was made.
    """
    read, stated = plan_files.read_plan(path)
    if stated != read.digest:
        raise FileError(path, f"was changed after it was made: it states digest {stated[:12]}")
    return read


def approve(cell: Cell, plan: Plan, proof: Proof, actor: str) -> Approval:
    """The word of a person, who has checked it, for exactly this plan in this cell.

    Args:
        cell: as it is now; how long the word stands is in its policy.
        plan: what will be sent.
        proof: of this plan.
        actor: the name of the person.

    Raises:
        CommandRefused: the proof does not hold, or plan, proof and cell do not belong together.
    """
    return approval.approve(cell, plan, proof, actor, time.time())


def open_session(folder: str | Path) -> Journal:
    """The journal of a recorded session; to be closed when nothing more is read.

    Args:
        folder: of the session.

    Raises:
        InputError: the folder holds none.
        JournalError: it cannot be opened.
    """
    return session_archive.open_journal(Path(folder))


def replay(session: Journal) -> Iterator[tuple[Entry, State]]:
    """Every entry of a session with the state that follows from it, computed again.

    Args:
        session: its journal; the first entry keeps the cell.

    Raises:
        JournalError: an entry cannot be read, the rules would not have let it pass, or another
            state follows from it than was recorded.
    """
    return replays.replay(session, cell_of(session))


def session_cases(folder: str | Path) -> tuple[Path, ...]:
    """The cases that a session has kept, for `read_case`, in the order in which they were.

    Args:
        folder: of the session.

    Raises:
        FileError: it cannot be read.
    """
    return case_folder.case_files(Path(folder))


def plate_poses(
    cell: Cell, plate: BallPlate, *, arm: str = "right", count: int = 8, seed: int = 0
) -> tuple[Floats, ...]:
    """Configurations (n,) [rad] of an arm in which the scanner sees the plate.

    Args:
        cell: whose arm and scanner.
        plate: held next to the tool; over the bin where the arm carries the scanner.
        arm: its name.
        count: how many are wanted; fewer come back where there are no more.
        seed: the same seed finds the same.
    """
    return ball_plate.suggested_poses(cell, cell.arm(arm), plate, count, seed=seed)


def simulate_plate(
    cell: Cell,
    q: Floats,
    plate: BallPlate,
    *,
    arm: str = "right",
    T_world_scanner: pin.SE3 | None = None,
    seed: int = 0,
) -> Scan:
    """What the scanner would see of a plate that an arm holds, or to which it carries the scanner.

    Args:
        cell: whose robot and scanner.
        q: (n,) [rad] of the arm, in chain order.
        plate: held next to the tool; over the bin where the arm carries the scanner.
        arm: its name.
        T_world_scanner: where the scanner truly hangs, on an arm at its view; where the cell says
            when not given.
        seed: of the scanner's noise.
    """
    return ball_plate.simulated_sight(
        cell, cell.arm(arm), q, plate, seed=seed, T_world_scanner=T_world_scanner
    )


def calibrate(cell: Cell, observations: Sequence[PlateObservation]) -> Calibration:
    """Where the scanner hangs, by a plate that was held or that its arm has shown it.

    Args:
        cell: for the robot's kinematics; where it has the scanner does not matter.
        observations: of one plate in one arm, by `sight_plate`; 4 at least, 8 are better.

    Raises:
        InputError: the observations do not belong together, are too few, too similar or at odds.
    """
    return calibrations.compute_calibration(cell, observations)


def corner_errors(cell: Cell, calibration: Calibration) -> dict[str, float]:
    """How far off what lies at the bin's corners is seen by a calibration alone.

    In 95 % of such calibrations it is no further off.  Robot, search and grip come on top.

    Returns:
        By the corner's name, such as `floor front left` [m].
    """
    T = calibration.T_world_scanner
    return calibrations.corner_errors(cell, calibration.covariance, T)

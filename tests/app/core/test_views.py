"""Several views of a scanner on an arm: chosen by name or by the bin, and gone to from another."""

from dataclasses import replace

import numpy as np
import pytest
from arm_scanner_cell import before_view, on_arm_cell, with_lower_view
from idle import Idle
from line import Line, refused

from workbench.app.core.cell.bins import ChooseBin, NewBin
from workbench.app.core.cell.changes import CellRead, ChangeCell, UndoCell
from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.cell.views import ChooseView
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.empty_hand import PlanView
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.effects import StartJob
from workbench.app.core.people import CELL_FILE, Role
from workbench.app.core.state import Phase, State
from workbench.app.empty_hand.view_plan import plan_view
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Cell
from workbench.model.derived.by_view import view_name, views_of, with_view
from workbench.model.digest import digest_of
from workbench.model.errors import JobCancelled
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.work import CancelText
from workbench.model.plan import PlanResult
from workbench.model.recipes.kit import KitItem, KitPart, KitProgress
from workbench.model.recipes.recipe import Recipe
from workbench.model.scan import Detection, Scan


@pytest.fixture(scope="session")
def cell() -> Cell:
    return with_lower_view(on_arm_cell())


@pytest.fixture
def line(cell: Cell) -> Line:
    return Line(cell)


def standing(cell: Cell) -> dict[str, float]:
    """Joints [rad] of all arms, by name, while the scanner is at the view that is chosen in it."""
    return cell.joint_values({arm.name: arm.home for arm in cell.arms})


def two_bins(cell: Cell) -> Cell:
    """Two bins, each seen from a view of its own; a recipe takes parts from the second one."""
    right = replace(cell.bin, name="right", number=1)
    away = pose_from_rpy((0, 2.0, 0)) * cell.bin.T_world_bin
    left = replace(right, name="left", number=2, T_world_bin=away)
    carrier = cell.scanner.on_arm
    assert carrier is not None
    first, second = carrier.views
    carrier = replace(
        carrier, view=replace(first, bin="right"), other_views=(replace(second, bin="left"),)
    )
    mount = replace(cell.scanner, on_arm=carrier)
    recipes = (Recipe(1, "to the left", bin="left"),)
    return replace(cell, bin=right, other_bins=(left,), scanner=mount, recipes=recipes)


def test_another_view_voids_the_scan_and_the_arm_has_to_go_there_first(cell, line):
    line.joints = standing(cell)
    T_world_scanner = cell.scanner.T_world_scanner
    line.do(UseScan(Scan(np.ones((3, 3)), T_world_scanner, "made", joints=line.joints)))
    state = line.do(ChooseView("low"))
    assert (view_name(state.cell), state.scan, state.phase) == ("low", None, Phase.IDLE)
    assert str(state.message) == "scans are taken from view low: go there"
    assert "does not stand at view low" in refused(line, TakeScan())
    line.do(PlanView())
    (job,) = [effect for effect in line.effects[-1:] if isinstance(effect, StartJob)]
    assert job.arguments["start"] == "bin"
    line.ended(plan_view(state.cell, start="bin"))
    assert "path to view low is planned" in str(line.state.message)
    line.joints = standing(state.cell)
    assert "stands at view low already" in refused(line, PlanView())
    line.do(TakeScan())


def test_back_at_the_first_view_nothing_of_the_choice_remains(cell, line):
    whole = line.do(ChooseView("low")).whole
    assert whole is not None and whole.digest == cell.digest
    state = line.do(ChooseView("bin"))
    assert state.cell.digest == cell.digest and state.whole is None


def test_a_path_begins_at_home_where_the_arm_stands_there(cell, line):
    line.joints = before_view(cell)
    line.do(ChooseView("low"))
    line.do(PlanView())
    assert isinstance(line.effects[-1], StartJob)
    assert line.effects[-1].arguments["start"] == "home"


def test_an_arm_that_stands_at_no_view_and_not_at_home_is_brought_there_by_hand(cell, line):
    carrier = cell.scanner.on_arm
    between = cell.joint_values({arm.name: arm.home for arm in cell.arms})
    between |= dict(zip(carrier.joints, (carrier.view.q + carrier.home) / 2, strict=True))
    line.joints = between
    line.do(ChooseView("low"))
    assert "begins at home (home_deg) or another view" in refused(line, PlanView())


def test_a_bin_and_a_recipe_take_their_view_along(cell):
    line = Line(two_bins(cell))
    assert view_name(line.do(ChooseBin("left")).cell) == "low"
    assert "no view bin sees this bin of cell" in refused(line, ChooseView("bin"))
    assert view_name(line.do(ChooseBin("right")).cell) == "bin"
    assert line.state.whole is None
    assert view_name(line.do(ChooseRecipe(1)).cell) == "low"
    assert [view.name for view in views_of(line.state.cell)] == ["low"]


def test_a_cycle_ends_where_the_arm_has_to_go_to_the_view_of_the_next_bin(cell):
    line = Line(two_bins(cell))
    line.joints = standing(cell)
    T_world_scanner = cell.scanner.T_world_scanner
    line.state = replace(line.state, phase=Phase.DONE)
    line.do(GoOn())
    line.ended(Scan(np.ones((3, 3)), T_world_scanner, "made", joints=line.joints))
    state = line.ended(())
    assert (state.cell.bin.name, view_name(state.cell), state.job) == ("left", "low", None)
    assert "nothing is left to take in bin right" in str(state.message)
    assert "does not stand at view low" in str(state.message)


@pytest.fixture
def done(cell, line) -> Line:
    """After a finished cycle, with the arm at the first view."""
    line.joints = standing(cell)
    line.state = replace(line.state, phase=Phase.DONE)
    return line


def shows(line: Line, detections: tuple[Detection, ...]) -> State:
    """The state after the scan and the search of a cycle."""
    T_world_scanner = line.state.cell.scanner.T_world_scanner
    line.ended(Scan(np.ones((3, 3)), T_world_scanner, "made", joints=line.joints))
    return line.ended(detections)


def path_goes(line: Line) -> None:
    """The path that is planned is sent and ended; then the arm stands at the chosen view."""
    assert line.state.job.name == "view"
    start = line.effects[-1].arguments["start"]
    line.ended(plan_view(line.state.cell, start=start))
    assert line.state.phase is Phase.PLANNED, "a person approves it"
    line.state = replace(line.state, phase=Phase.DONE)
    line.joints = standing(line.state.cell)


def test_a_cycle_that_finds_nothing_plans_the_path_to_the_next_view_of_its_bin(cell, done):
    done.do(GoOn())
    state = shows(done, ())
    assert (view_name(state.cell), state.job.name) == ("low", "view")
    assert "view low is next, as nothing can be taken from view bin" in str(state.message)
    path_goes(done)
    assert str(done.state.message).startswith(
        "views from which nothing can be taken: bin; the path"
    )
    done.do(GoOn())
    state = shows(done, ())
    assert (view_name(state.cell), state.job) == ("low", None), "each view had its turn"
    assert str(state.message) == "no part found; no further cycle starts"
    # Somebody may have filled the bin meanwhile: the next cycle begins another round.
    done.state = replace(state, phase=Phase.DONE)
    done.do(GoOn())
    assert view_name(shows(done, ()).cell) == "bin"


def test_where_no_plan_comes_out_the_next_view_has_its_turn_until_something_is_taken(done):
    found = (Detection("keyed_cylinder", pose_from_rpy((0.41, 0.0, 0.02))),)
    verdict = Verdict(Reason.EXTRACT_BLOCKED, Stage.ROUTE)
    nothing = PlanResult((), None, None, verdict, {})
    done.do(GoOn())
    shows(done, found)
    assert done.ended(nothing).job.name == "view"
    path_goes(done)
    done.do(GoOn())
    # That parts are found is not yet that one can be taken.
    assert shows(done, found).views_without == ("bin",)
    state = done.ended(nothing)
    assert (state.job, state.views_without) == (None, ("bin", "low"))
    late = replace(nothing, verdict=Verdict(Reason.OUT_OF_TIME, Stage.ROUTE))
    done.state = replace(state, phase=Phase.DONE, views_without=())
    done.do(GoOn())
    shows(done, found)
    assert done.ended(late).job is None, "more time may bring a plan"


def test_a_bin_counts_as_empty_once_each_of_its_views_has_shown_that(cell):
    several = two_bins(cell)
    carrier = several.scanner.on_arm
    views = [replace(view, bin="") for view in carrier.views]
    carrier = replace(carrier, view=views[0], other_views=(views[1],))
    line = Line(replace(several, scanner=replace(several.scanner, on_arm=carrier)))
    line.joints = standing(cell)
    line.state = replace(line.state, phase=Phase.DONE)
    line.do(GoOn())
    state = shows(line, ())
    assert (state.cell.bin.name, view_name(state.cell)) == ("right", "low")
    assert state.empty_bins == ()
    path_goes(line)
    line.do(GoOn())
    state = shows(line, ())
    assert (state.empty_bins, state.cell.bin.name) == (("right",), "left")
    assert (state.views_without, state.job.name) == ((), "scan")
    line.ended(JobCancelled(CancelText.SCAN()))
    line.do(ChooseBin("right"))
    line.state = replace(line.state, views_without=("bin", "low"))
    assert line.do(NewBin("right")).views_without == ()


def test_what_a_kit_lacks_is_looked_for_from_each_view(cell):
    cylinder = cell.part("keyed_cylinder")
    both = Recipe(1, "both", items=(KitItem("keyed_cylinder", 1), KitItem("cap", 1)))
    kinds = (cylinder, replace(cylinder, name="cap"))
    line = Line(replace(cell, parts=kinds, recipes=(both,), recipe=1))
    kit = KitProgress((KitPart("keyed_cylinder", "plan", 0),))
    line.joints = standing(cell)
    line.state = replace(line.state, phase=Phase.DONE, kit=kit, whole=cell)
    line.do(GoOn())
    state = shows(line, (Detection("keyed_cylinder", pose_from_rpy((0.41, 0.0, 0.02))),))
    assert (view_name(state.cell), state.job.name) == ("low", "view")
    assert "the kit lacks 1 cap, and none was found" in str(state.message)
    assert "view low is next" in str(state.message)


def test_a_cycle_ends_where_no_path_to_the_next_view_can_begin(cell, done):
    done.do(GoOn())
    T_world_scanner = cell.scanner.T_world_scanner
    done.ended(Scan(np.ones((3, 3)), T_world_scanner, "made", joints=done.joints))
    carrier = cell.scanner.on_arm
    between = (carrier.view.q + carrier.home) / 2
    done.joints = done.joints | dict(zip(carrier.joints, between, strict=True))
    state = done.ended(())
    assert (view_name(state.cell), state.job) == ("low", None)
    assert "begins at home (home_deg) or another view" in str(state.message)


def test_unknown_views_are_refused(line):
    assert "there is bin, low" in refused(line, ChooseView("high"))
    assert "there is bin, low" in refused(line, ChooseView(""))
    assert "taken from view bin; choose view low first" in refused(line, PlanView("low"))
    assert "hangs on no arm" in refused(Line(read_cell("yumi")), ChooseView("low"))


def test_the_cell_is_changed_and_undone_while_another_view_is_chosen(cell, line):
    lower = line.do(ChooseView("low")).cell
    moved = pose_from_rpy((0.01, 0, 0)) * lower.bin.T_world_bin
    changed = replace(lower, bin=replace(lower.bin, T_world_bin=moved))
    state = line.do(ChangeCell(changed, "moved"))
    assert state.cell.digest == changed.digest and view_name(state.whole) == "bin"
    assert state.whole.digest == with_view(changed, "bin").digest
    assert line.do(UndoCell()).cell.digest == lower.digest


def test_a_file_that_loses_the_chosen_view_is_used_as_it_stands(cell, line):
    line.do(ChooseView("low"))
    carrier = replace(cell.scanner.on_arm, other_views=())
    without = replace(cell, scanner=replace(cell.scanner, on_arm=carrier))
    state = line.do(CellRead(without), CELL_FILE)
    assert (state.cell.digest, state.whole, state.scan) == (without.digest, None, None)
    assert "the cell is used as its file states it" in str(state.message)


def test_a_session_in_which_views_are_chosen_is_computed_again(cell, tmp_path):
    journal = Journal(tmp_path / "session")
    bench = Bench(cell, journal, effects=Idle)
    bench.do(ChooseView("low"), "ada", Role.OPERATOR)
    last = bench.state
    bench.close()
    *_, (_, again) = replay(Journal(tmp_path / "session"), cell)
    assert digest_of(again) == digest_of(last) and view_name(again.cell) == "low"


def test_each_view_has_its_own_pose_of_the_scanner(cell):
    low = with_view(cell, "low")
    away = low.scanner.T_world_scanner.translation - cell.scanner.T_world_scanner.translation
    assert away == pytest.approx((0.0, 0.0, -0.05), abs=1e-3)
    assert not np.array_equal(low.arm("left").home, cell.arm("left").home)
    assert with_view(low, "bin").digest == cell.digest

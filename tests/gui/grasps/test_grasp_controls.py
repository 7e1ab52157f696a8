"""The controls in which grasps are edited, without a browser: what they leave as it was."""

import logging
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from few_grasps import HAND, PART, grasp_now, with_grasps

import workbench.gui.grasps.coverage
from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.people import Role
from workbench.app.statistics.grasp_use import GraspUse
from workbench.formats.files.shipped import find
from workbench.formats.parts.grasp_files import save_grasps
from workbench.formats.parts.reading import read_part
from workbench.formats.parts.saves import Version, versions, write_draft
from workbench.gui.grasps.coverage import CoverageControls, axis_message
from workbench.gui.grasps.editing import Editing
from workbench.gui.grasps.fields import GraspFields
from workbench.gui.grasps.ideas import Suggestions
from workbench.gui.grasps.library import NOW as AS_IT_IS
from workbench.gui.grasps.library import LibraryControls
from workbench.gui.grasps.panel import GraspsPanel
from workbench.gui.grasps.views import check_line, grasps_html, refused_message, versions_html
from workbench.gui.shared.colours import BUSY, GOOD
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import GraspLibrary, GraspPair, grasps_of
from workbench.model.part_edits import grasp_of
from workbench.model.robot import Tcp
from workbench.planning.grasps.firmness import Firmness, in_words
from workbench.planning.grasps.grasp_check import GraspCheck, GraspFinding


@pytest.mark.parametrize(
    "grasp",
    [
        replace(HAND, tool="suction_cup_of_another_cell"),
        replace(HAND, tcp="of_another_cell"),
        replace(HAND, arms=("third",)),
        replace(HAND, arms=("left", "third")),
        replace(HAND, arms=("left", "right")),
        replace(HAND, arms=("right", "left")),
    ],
)
def test_tools_and_arms_of_other_cells_are_left_alone(bench, visitor, grasp):
    with_grasps(bench, grasp)
    fields = GraspFields(visitor, Editing(visitor))
    fields.show(grasp, problem="")
    assert not fields.is_typed()
    fields._priority.value = 5
    fields._take()
    now = grasp_now(bench)
    assert (now.priority, now.tool, now.arms) == (5, grasp.tool, grasp.arms)
    assert now.tcp == grasp.tcp


def test_a_grasp_is_for_the_tcp_that_is_chosen_where_tools_name_some(bench, visitor):
    with_grasps(bench, HAND)
    fields = GraspFields(visitor, Editing(visitor))
    fields.show(HAND, problem="")
    assert not fields._tcp.visible
    cell = bench.state.cell
    tip = Tcp("tip", cell.arms[0].tool.T_flange_tcp)
    arms = tuple(
        replace(arm, tool=replace(arm.tool, tcps=(tip,), tcp="tip"), tools=()) for arm in cell.arms
    )
    bench.do(ChangeCell(replace(cell, arms=arms), "a name"), "Ada", Role.ENGINEER)
    editing = Editing(visitor)
    fields = GraspFields(visitor, editing)
    fields.show(HAND, problem="")
    assert fields._tcp.visible
    fields._tcp.value = "tip"
    fields._take()
    assert grasp_now(bench).tcp == "tip"
    assert editing.check(replace(HAND, tcp="")).tool == cell.arms[0].tool.name


def test_boxes_say_which_arms_of_this_cell_may_use_a_grasp(bench, visitor):
    with_grasps(bench, HAND)
    fields = GraspFields(visitor, Editing(visitor))
    fields.show(HAND, problem="")
    fields._arms["left"].value = False
    fields._take()
    assert grasp_now(bench).arms == ("right",)
    fields._arms["left"].value = True
    fields._take()
    assert grasp_now(bench).arms == ()
    fields._arms["left"].value = fields._arms["right"].value = False
    fields._take()
    assert "no arm may use it" in visitor.client.told[-1]


@pytest.fixture
def two_parts(bench):
    cell = bench.state.cell
    other = read_part(find("parts", "bolt"))
    with_both = replace(cell, parts=(*cell.parts, other))
    bench.do(ChangeCell(with_both, "another part"), "Ada", Role.ENGINEER)
    return other


def test_suggestions_for_a_part_are_not_taken_for_another_one(bench, visitor, two_parts):
    editing = Editing(visitor)
    suggestions = Suggestions(visitor, editing, lambda grasp: None)
    suggestions._look()
    suggestions.show(editing.part)
    assert suggestions._found and not suggestions._take.disabled
    editing.choose(part=two_parts.name)
    suggestions.show(editing.part)
    assert not suggestions._found and suggestions._take.disabled and suggestions._all.disabled


def test_a_suggestion_whose_name_was_taken_meanwhile_gets_another_one(bench, visitor):
    editing = Editing(visitor)
    suggestions = Suggestions(visitor, editing, lambda grasp: None)
    suggestions._look()
    first, second = suggestions._found[:2]
    editing.add((replace(HAND, name=first.grasp.name),), "somebody was quicker")
    suggestions._add((first, second))
    names = [entry.name for entry in bench.state.cell.part(PART).library.entries]
    assert len(set(names)) == len(names) == 4


def test_once_all_suggestions_are_taken_nothing_is_said_of_what_else_would_be_found(bench, visitor):
    suggestions = Suggestions(visitor, Editing(visitor), lambda grasp: None)
    suggestions._look()
    suggestions._add(suggestions._found)
    assert suggestions._table.content == "" and suggestions._all.disabled


def test_coverage_of_a_cell_that_was_changed_meanwhile_is_not_shown(bench, visitor, monkeypatch):
    editing = Editing(visitor)
    stage = SimpleNamespace(hide_sphere=lambda: None, is_open=False)  # nobody looks at it
    controls = CoverageControls(visitor, editing, stage)

    def slow(cell, part, **_):
        moved = replace(cell.bin, T_world_bin=pose_from_rpy((0.1, 0, 0)) * cell.bin.T_world_bin)
        bench.do(ChangeCell(replace(cell, bin=moved), "moved"), "Ada", Role.ENGINEER)
        return SimpleNamespace(missing=None)

    monkeypatch.setattr(workbench.gui.grasps.coverage, "coverage", slow)
    monkeypatch.setattr(workbench.gui.grasps.coverage, "coverage_texts", lambda found: ["90 %"])
    controls._work()
    controls.show(editing.part, problem="")
    assert "Not checked since" in controls._line.content


def test_nobody_goes_on_looking_for_who_has_gone(visitor):
    controls = CoverageControls(visitor, Editing(visitor), SimpleNamespace())
    visitor.end(is_gone=True)
    assert controls._cancelled.is_set()


def test_a_look_that_ends_after_the_controls_draws_nothing(visitor, monkeypatch):
    panel = GraspsPanel(visitor)
    drawn = []
    monkeypatch.setattr(panel, "_draw_all", lambda: drawn.append(1))
    panel._draw()
    visitor.end(is_gone=False)
    panel._draw()
    assert len(drawn) == 1


def test_a_grasp_that_cannot_be_looked_at_is_logged(visitor, monkeypatch, caplog):
    panel = GraspsPanel(visitor)

    def broken(self, grasp):
        raise ValueError("no hull")

    monkeypatch.setattr(Editing, "check", broken)
    with caplog.at_level(logging.ERROR):
        panel._look_at_all(panel._editing.part)
        panel._looker.shutdown()
    assert "could not be looked at" in caplog.text


def test_versions_that_cannot_be_read_are_told_and_those_of_another_part_are_gone(
    visitor, bench, tmp_path, monkeypatch
):
    editing = Editing(visitor)
    library = LibraryControls(visitor, editing)
    visitor.folders = {PART: tmp_path}
    state, part = bench.state, editing.part
    saved = replace(state, saved=state.cell.digest)
    (tmp_path / "versions").mkdir()
    write_draft(tmp_path, part.library)
    (tmp_path / "grasps.draft.toml").rename(tmp_path / "versions" / "0001.toml")
    line = '{"version": 1, "at": "2026-01-01T00:00:00Z", "by": "Ada", "remark": "first"}\n'
    (tmp_path / "changes.log").write_text(line)
    assert len(versions(tmp_path)) == 1
    library.show(saved, part, problem="")
    assert library._version.options == (AS_IT_IS, "1: first")

    (tmp_path / "versions" / "0001.toml").write_text("not [ a file")
    library.show(replace(saved, saved="other"), part, problem="")
    assert "0001.toml" in library._changes.content
    library._version.value = "1: first"
    library._gone_back()
    assert "0001.toml" in visitor.client.told[-1]

    def unreadable(folder):
        raise InputError("changes.log cannot be read")

    monkeypatch.setattr("workbench.gui.grasps.library.versions", unreadable)
    library.show(saved, part, problem="")
    assert "changes.log cannot be read" in library._draft.content
    assert library._version.options == (AS_IT_IS,)


@pytest.mark.parametrize(
    ("direction", "words"),
    [
        ((0.0, 0.0, 1.0), "+z"),
        ((0.0, -1.0, 0.0), "-y"),
        ((0.07, -0.17, 0.98), "+z (to within 11 deg)"),
    ],
)
def test_a_direction_of_a_part_is_said_by_its_nearest_axis(direction, words):
    assert str(axis_message(np.array(direction))) == words


def test_measure_fills_in_and_applies_nothing(bench, visitor):
    side = grasp_of(bench.state.cell.part(PART).library.entries[0])
    tight = replace(side, opening=0.049, grip=0.001)
    with_grasps(bench, tight)
    fields = GraspFields(visitor, Editing(visitor))
    fields.show(tight, problem="")
    fields._priority.value = 5
    fields._fit()
    assert visitor.client.told == []
    assert grasp_now(bench) is tight and fields.is_typed()
    assert fields._grip.value > 1.0 and fields._priority.value == 5
    fields._take()
    assert grasp_now(bench).priority == 5 and grasp_now(bench).grip > tight.grip


def test_every_grasp_is_tried_with_the_tool_that_it_is_for(bench, visitor):
    cell = bench.state.cell
    arm = cell.arms[0]
    wide = replace(arm.tool, name="wide", stroke=(0.0, 0.1))
    two = replace(cell, arms=(replace(arm, tools=(arm.tool, wide)), *cell.arms[1:]))
    bench.do(ChangeCell(two, "another tool"), "Ada", Role.ENGINEER)
    for_wide = replace(HAND, name="wide one", tool="wide", opening=0.09)
    with_grasps(bench, HAND, for_wide)
    panel = GraspsPanel(visitor)
    editing = panel._editing
    assert editing.entry is not None and editing.entry.name == HAND.name
    assert editing.check(HAND).tool == arm.tool.name
    assert editing.check(for_wide).tool == "wide"
    assert not any("opens" in str(finding.text) for finding in editing.check(for_wide).findings)
    check = GraspCheck("side", "wide", (GraspFinding("cut", "the jaws touch", 0.001),), None, 0.0)
    assert "with the wide: the jaws touch" in check_line("side", check)


def test_how_much_of_the_load_a_grip_holds_is_said_where_it_is_known():
    firm = Firmness(1.84, (0.0, 0.0, 1.0), False, 2.0, 4.41, 20.0, 0.4, False)
    check = GraspCheck("side", "hand", (), 0.02, 0.004)
    assert "times the load" not in check_line("side", check)
    said = check_line("side", replace(check, firmness=firm))
    assert (
        "clearance 4.0 mm on arrival, holds 1.8 times the load (20 N, friction 0.4, 4.4 m/s2)"
        in said
    )
    weak = [replace(firm, share=share, turns=True) for share in (0.5, 0.929)]
    refused = [
        replace(check, findings=(GraspFinding("weight", in_words(one), one.share),)) for one in weak
    ]
    told = str(refused_message(refused))
    assert told.startswith(
        "Left out for the weight: 2; the firmest would turn in the fingers: 0.92"
    )


def test_a_remark_goes_once_it_is_saved(bench, visitor):
    editing = Editing(visitor)
    library = LibraryControls(visitor, editing)
    with_grasps(bench, HAND)
    changed = bench.state
    library._remark.value = "deeper"
    library._save_library()
    library.show(changed, editing.part, problem="")
    assert library._remark.value == "deeper", "it is not in the files yet"
    saved = replace(changed, saved=changed.cell.digest)
    library.show(saved, editing.part, problem="")
    assert library._remark.value == ""
    library._remark.value = "another one"
    library.show(saved, editing.part, problem="")
    assert library._remark.value == "another one"


def test_the_tab_names_its_part_also_where_the_cell_has_no_other(bench, visitor):
    panel = GraspsPanel(visitor)
    assert [part.name for part in bench.state.cell.parts] == [PART]
    assert panel._part.visible and panel._part.value == PART
    assert panel._upload._pick._pick.order < panel._part.order, "a new part is made at the top"


def test_a_name_is_quoted_as_it_is_at_the_beginning_of_a_sentence(bench, visitor):
    with_grasps(bench, replace(HAND, name="by_hand"))
    panel = GraspsPanel(visitor)
    check = panel._editing.check(grasp_now(bench))
    assert "&quot;by_hand&quot;: " in check_line("by_hand", check)
    panel._fields.show(grasp_now(bench), problem="")
    panel._fields._priority.value = 5
    panel._fields._take()
    assert str(bench.state.message) == 'grasp "by_hand" is edited'


def test_a_draft_of_one_change_is_told_of_and_one_of_none_is_not(visitor, bench, tmp_path):
    editing = Editing(visitor)
    library = LibraryControls(visitor, editing)
    visitor.folders = {PART: tmp_path}
    state, part = bench.state, editing.part
    saved = replace(state, saved=state.cell.digest)
    save_grasps(tmp_path / "grasps.toml", part.library)
    save_grasps(tmp_path / "grasps.draft.toml", part.library)
    library.show(saved, part, problem="")
    assert library._draft.content == "" and not library._take.visible
    first = part.library.entries[0].name
    write_draft(tmp_path, replace(part.library, pairs=(GraspPair(first, first),)))
    library.show(saved, part, problem="")
    assert "a draft with 1 change not saved" in library._draft.content
    assert library._take.visible and library._drop.visible


def test_versions_are_told_in_the_zone_that_all_times_are_told_in(tmp_path):
    said = [
        versions_html((Version(1, at, "Ada", "first", tmp_path),))
        for at in ("2026-01-01T00:05:00Z", "some day")
    ]
    assert "2026-01-01 00:05 UTC" in said[0] and "some day" in said[1]


@pytest.mark.parametrize(
    ("use", "light"),
    [(GraspUse(), GOOD), (GraspUse(tried=6, possible=1), GOOD), (GraspUse(tried=6), BUSY)],
)
def test_a_grasp_that_never_worked_in_the_bin_is_not_green(use, light):
    part = read_part(find("parts", PART))
    name = part.library.entries[0].name
    part = replace(part, library=GraspLibrary(part.library.entries[:1]))
    checks = {name: GraspCheck(name, "hand", (), 0.03, 0.005)}
    uses = {(PART, grasp.name): use for grasp in grasps_of(part.library.entries[0])}
    assert f"background:{light}" in grasps_html(part, "", checks, ["row"], uses)

"""The error budget of a pick: from what is not known to where the part comes to lie."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from resting_parts import brick, hand, plain, tcp_over

from workbench.formats.cells.reading import read_cell
from workbench.model.calibration import CalibrationRecord
from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.geometry import Cylinder
from workbench.model.messages.grasps import BudgetText
from workbench.model.part import Grasp, PartPlace
from workbench.model.scan import Detection
from workbench.model.symmetry import Symmetry
from workbench.planning.placing.budget import GRIP, LOCALIZATION, budget_by, budget_of
from workbench.planning.placing.sources import scanner_error

EXACT = CalibrationRecord(0.0, "Ada", 8, 0.0, position_error=0.0, angle_error=0.0)
OK = Verdict(Reason.OK, Stage.PROPOSE)


def cell_with(part, place=None):
    cell = read_cell("yumi")
    arm = replace(cell.arms[0], tool=hand(), part_places=() if place is None else (place,))
    mount = replace(cell.scanner, calibration=EXACT)
    return replace(cell, arms=(arm,), parts=(part,), scanner=mount)


def budget(lying, deviations, place=None, tool=None, along=0.0):
    part, T = lying
    cell = cell_with(part, place)
    if tool is not None:
        cell = replace(cell, arms=(replace(cell.arms[0], tool=tool),))
    detection = Detection(part.name, T, covariance=np.diag(np.square(deviations)))
    T_world_tcp = tcp_over(T, along)
    grasp = Grasp("over", T.actInv(T_world_tcp), 0.04, 0.02)
    return budget_of(cell, detection, Candidate(0, grasp, cell.arms[0].name, T_world_tcp, 0.0, OK))


def test_the_shares_add_up_to_the_whole():
    told = budget(brick(0.02), [1e-3, 2e-3, 3e-3, 0.01, 0.02, 0.03])
    assert np.allclose(sum(told.shares.values()), told.covariance)
    assert np.allclose(told.covariance, told.covariance.T)
    assert np.linalg.eigvalsh(told.covariance).min() > -1e-15


def test_what_comes_onto_the_part_gets_all_of_it_along_the_part_s_axes():
    part, T = brick(0.02)
    cell = cell_with(part)
    detection = Detection(part.name, T, covariance=np.diag([1e-6] * 3 + [1e-4] * 3))
    off = CalibrationRecord(0.0, "Ada", 8, 0.0, position_error=1e-3, angle_error=1e-3)
    cell = replace(cell, scanner=replace(cell.scanner, calibration=off))
    told = budget_by(cell, detection, cell.arms[0].name, T.actInv(tcp_over(T, 0.0)))
    by_scanner = told.error.by_scanner
    whole = by_scanner @ scanner_error(cell.scanner) @ by_scanner.T + told.error.covariance
    turn = np.kron(np.eye(2), told.R_part_hand)
    assert np.allclose(whole, turn @ told.covariance @ turn.T, atol=1e-15)
    assert np.linalg.norm(by_scanner) > 0.1


def test_an_error_along_the_travel_of_the_fingers_is_gone_and_one_along_the_pads_stays():
    # The fingers close along y of the world.
    gone = budget(brick(0.02), [0, 2e-3, 0, 0, 0, 0])
    stays = budget(brick(0.02), [2e-3, 0, 0, 0, 0, 0])
    assert gone.shift < 5e-4 and gone.largest[0] == GRIP
    assert stays.shift == pytest.approx(1.96 * 2e-3, rel=0.03)
    assert stays.largest == (LOCALIZATION, BudgetText.ACROSS_PADS)


def test_a_turn_about_the_travel_stays_and_moves_the_part_that_is_held_beside_its_middle():
    middle = budget(brick(0.02), [0, 0, 0, 0, 0.05, 0])
    assert middle.turn == pytest.approx(1.96 * 0.05, rel=0.03)
    assert middle.largest == (LOCALIZATION, BudgetText.ABOUT_TRAVEL)
    # The search has turned it about its origin; so has the hand.
    assert middle.shift < 5e-4


def test_the_chance_of_a_place_is_that_of_its_tolerances():
    narrow, wide = (
        PartPlace(pin.SE3.Identity(), tolerance=far, turn_tolerance=0.1) for far in (1e-3, 3e-3)
    )
    deviations = [1e-3, 1e-3, 0, 0, 0, 0]
    told = budget(brick(0.02), deviations, narrow)
    # Of one direction is left: 68.3 % are within one deviation of it, 99.7 % within three.
    assert told.chance == pytest.approx(0.683, abs=0.02)
    assert told.chance_at(wide) == pytest.approx(0.997, abs=0.003)
    assert budget(brick(0.02), deviations).chance is None


def test_a_part_for_another_place_has_no_chance_there():
    other = PartPlace(pin.SE3.Identity(), part="another")
    assert budget(brick(0.02), [1e-3] * 6, other).place is None


def test_a_cup_leaves_what_is_beside_its_axis():
    cup = replace(hand(), fingers=())
    told = budget(brick(0.02), [1e-3, 1e-3, 0, 0, 0, 0], tool=cup)
    assert np.sqrt(np.diag(told.covariance)[:3]) == pytest.approx([1e-3, 1e-3, 0.0], abs=2e-5)
    assert told.largest[1] == BudgetText.ACROSS_TOOL
    upright = budget(brick(0.02), [0, 0, 2e-3, 0, 0, 0], tool=cup)
    assert upright.shift < 1e-4


def test_a_rod_that_rolls_as_it_is_pushed_counts_unless_it_is_round():
    T = pin.SE3(pin.rpy.rpyToMatrix(0, np.pi / 2, 0), np.array([0.0, 0.0, 0.01]))
    keyed = plain(Cylinder(0.01, 0.06))
    deviations = [0, 1e-3, 0, 0, 0, 0]
    assert budget((keyed, T), deviations).turn == pytest.approx(1.96 * 0.1, rel=0.1)
    alike = plain(Cylinder(0.01, 0.06), Symmetry(np.array([0.0, 0.0, 1.0]), 0))
    assert budget((alike, T), deviations).turn < 0.02


def test_it_says_in_one_sentence_how_far_and_why():
    place = PartPlace(pin.SE3.Identity())
    words = budget(brick(0.02), [2e-3, 0, 0, 0, 0, 0], place).words
    assert str(words) == (
        "placement error: 3.9 mm, 0.0 deg (95%); largest contribution: localization (across the "
        "pads); 69% of picks are within the tolerances of the place, 2.0 mm and 3.0 deg"
    )


def test_a_refused_candidate_and_a_hand_that_misses_are_told_of_too():
    told = budget(brick(0.02), [1e-3] * 3 + [0.01] * 3, along=0.5)
    assert told.shift > 1e-3 and np.isfinite(told.covariance).all()

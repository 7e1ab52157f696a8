"""What a person asks for on the page: piles, the film of each, and changes."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.core.cell.emptying import TryEmptying
from workbench.app.emptying.empty import empty_pile, fallen
from workbench.app.emptying.piles import emptied_piles
from workbench.formats.cells.reading import read_cell
from workbench.model.errors import InputError, JobCancelled
from workbench.model.part import GraspLibrary
from workbench.model.prediction import PileTask
from workbench.plugins.progress import never, silent

ASKED = TryEmptying(count=4, piles=2, seed=12)


@pytest.fixture(scope="module")
def cell():
    return read_cell("yumi")


@pytest.fixture(scope="module")
def told():
    return []


@pytest.fixture(scope="module")
def found(cell, told):
    return emptied_piles(cell, ASKED, lambda done, note: told.append((done, note)), never)


@pytest.mark.extensive
def test_looks_beside_a_motion_are_told_where_the_scanner_sees_then(found, cell):
    assert all(one.beside == () for one in found.emptying.piles)
    seeing = replace(cell, scanner=replace(cell.scanner, while_moving=True))
    asked = replace(ASKED, piles=1)
    (pile,) = emptied_piles(seeing, asked, silent, never).emptying.piles
    assert pile.taken == found.emptying.piles[0].taken
    # After each plan that took what it was to take, as long as something lay there still.
    assert 1 <= len(pile.beside) <= pile.cycles
    assert all(moves > 1.0 and took > 0.0 for moves, took in pile.beside)


def test_each_pile_has_the_next_seed_and_is_told_of(found, told, cell):
    emptying = found.emptying
    assert [one.task.seed for one in emptying.piles] == [12, 13]
    assert emptying.cell_digest == cell.digest and emptying.plain == emptying.piles
    shares = [done for done, _ in told]
    assert shares == sorted(shares) and shares[0] >= 0.0 and shares[-1] <= 1.0
    notes = [str(note) for _, note in told]
    assert "pile 1 of 2: 0 of 4 taken" in notes and "pile 2 of 2: the parts fall" in notes


def test_the_film_of_a_pile_is_what_became_of_it(found):
    for film, pile in zip(found.films, found.emptying.piles, strict=True):
        picks = [pick for shot in film.shots for pick in shot.picks]
        assert tuple(pick.outcome for pick in picks) == pile.outcomes
        assert len(film.shots) == pile.cycles and len(film.fallen) == pile.parts == 4
        assert {f"part-{k + 1}" for k, _ in film.left} == {one.part for one in pile.left}
        there = {k for k, _ in film.fallen}
        for shot in film.shots:
            assert {k for k, _ in shot.before} == there
            for pick in shot.picks:
                assert pick.number in there
                there = {k for k, _ in pick.after}
                assert pick.number not in there
        assert there == {k for k, _ in film.left}
    assert any(pile.taken for pile in found.emptying.piles)


def test_a_part_lies_in_the_hand_as_it_lay_in_the_bin(found, cell):
    """At the moment of gripping the hand has it where the pile has it."""
    from workbench.planning.kinematics.robot import Kinematics

    kinematics = Kinematics(cell)
    shot = next(shot for film in found.films for shot in film.shots)
    pick = shot.picks[0]
    q = np.asarray(shot.plan.arm(pick.arm).leg("extract").q[0])
    held = kinematics.tcp_pose(cell.arm(pick.arm), q) * pick.T_tcp_part
    lay = dict(shot.before)[pick.number].T_world_part
    assert np.linalg.norm(held.translation - lay.translation) < 1e-4


def test_changes_are_tried_on_the_same_piles(cell):
    asked = replace(ASKED, count=2, piles=1, changes=("lifts",))
    found = emptied_piles(cell, asked, silent, never)
    changes = [one.task.change for one in found.emptying.piles]
    assert changes[0] is None and len(changes) > 1 and None not in changes[1:]
    assert len(found.films) == len(found.emptying.plain) == 1
    assert {one.task.seed for one in found.emptying.piles} == {12}


def test_who_cancels_gets_no_half_result(cell):
    looks = []

    def after_the_first_pile(done: float = 0.0, note: str = "") -> None:
        looks.append(str(note))

    with pytest.raises(JobCancelled, match="cancelled"):
        emptied_piles(cell, ASKED, after_the_first_pile, lambda: any("pile 2" in n for n in looks))


def test_what_cannot_be_piled_up_or_taken_is_refused(cell):
    part = replace(cell.parts[0], library=GraspLibrary(()))
    with pytest.raises(InputError, match="part keyed_cylinder has no grasp"):
        emptied_piles(replace(cell, parts=(part,)), ASKED, silent, never)
    small = replace(cell, bin=replace(cell.bin, size=cell.bin.size * 0.5))
    with pytest.raises(InputError, match=r"do not fit into the bin; take \d+ or fewer"):
        emptied_piles(small, replace(ASKED, count=30), silent, never)


def test_where_nothing_can_be_taken_a_hand_stirs_as_often_as_the_cell_says():
    cell = read_cell("robots/tx2_90/full_bin.toml")
    task = PileTask(cell.name, "puck", 12, 905111)
    pile = fallen(cell, cell, task)
    plain = empty_pile(cell, task, pile)
    stirring = replace(cell, policy=replace(cell.policy, stirs=2))
    shots = []
    found = empty_pile(stirring, task, pile, film=shots.append)
    assert plain.taken < plain.parts and plain.stirs == 0
    assert found.taken > plain.taken and found.stirs > 0 and found.cycles == len(shots)
    stirs = [shot for shot in shots if shot.stirred]
    assert len(stirs) == found.stirs and all(shot.plan.is_stir_plan for shot in stirs)
    for shot in stirs:
        assert len(shot.stirred) == len(shot.plan.arms[0].leg("stir").q)
        assert {k for k, _ in shot.after} <= {k for k, _ in shot.before}
    assert sum(shot.plan.cycle_seconds for shot in shots) == pytest.approx(found.motion_seconds)

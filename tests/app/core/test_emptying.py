"""Piles emptied in simulation: whose it is, what is refused, and what becomes of the result."""

from dataclasses import replace

import pytest
from line import Line, planned_line, refused

from workbench.app.core.cell.emptying import TryEmptying
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.decide import check_allowed
from workbench.app.core.effects import Send, StartJob, StopJob
from workbench.app.core.people import WORKER, Role
from workbench.app.core.rights import lacks_right
from workbench.app.core.state import Phase
from workbench.app.core.value_checks import MOST_PARTS, MOST_PILES
from workbench.model.errors import InputError, JobCancelled, NotAllowed
from workbench.model.messages.changes import ChangeText
from workbench.model.messages.message import Message, plain
from workbench.model.prediction import EmptiedPile, Emptying, LeftPart, PileTask


def emptied(cell, *changes: Message) -> Emptying:
    left = (LeftPart("part-2", "tool collision", plain("why"), "a fix"),)
    piles = tuple(
        EmptiedPile(PileTask(cell.name, "peg", 2, 3, change=change), 2, 1, (0, 0, 0), 0, 0, 1, 4,
                    5.0, left, (0.1,), (("propose", 0.1),), 0.0, outcomes=("",))
        for change in (None, *changes)
    )  # fmt: skip
    return Emptying(cell.digest, piles)


@pytest.fixture
def line(cell):
    return Line(cell)


def test_it_is_a_task_whose_result_stays_until_the_next_one(line, cell):
    line.do(TryEmptying(count=2, piles=1, seed=3))
    assert str(line.state.message) == "emptying 1 pile of 2 parts in simulation"
    (start,) = line.effects
    assert isinstance(start, StartJob) and start.name == "emptying"
    found = emptied(cell, ChangeText.UP_ALONE())
    assert line.ended(found).emptying is found
    assert (
        str(line.state.message) == "1 of 2 parts taken out of 1 pile in simulation; 1 change tried"
    )
    # It says something about the cell, not about a scan: those that follow leave it alone.
    line.do(TakeScan())
    assert line.state.emptying is found and line.state.phase is Phase.IDLE


def test_it_touches_nothing_of_the_cycle_and_sends_nothing(samples, cell):
    line = planned_line(samples, cell)
    before = line.state
    line.do(TryEmptying())
    after = line.ended(emptied(cell))
    for field in ("scan", "detections", "plan", "proof", "phase", "cell"):
        assert getattr(after, field) is getattr(before, field)
    assert not any(isinstance(one, Send) for one in line.effects)


@pytest.mark.parametrize(
    ("command", "says"),
    [
        (TryEmptying(kinds=("screw",)), "part 'screw' is not known; there are peg"),
        (TryEmptying(kinds=("peg", "peg")), "each part is named once, not peg, peg"),
        (TryEmptying(count=0), f"parts must be a whole number from 1 to {MOST_PARTS}, not 0"),
        (TryEmptying(count=31), f"parts must be a whole number from 1 to {MOST_PARTS}, not 31"),
        (TryEmptying(count=2.5), "parts must be a whole number"),
        (TryEmptying(count=True), "parts must be a whole number"),
        (TryEmptying(piles=0), f"piles must be a whole number from 1 to {MOST_PILES}, not 0"),
        (TryEmptying(piles=10**9), f"piles must be a whole number from 1 to {MOST_PILES}"),
        (TryEmptying(seed=-1), "seed must be a whole number from 0"),
        (TryEmptying(seed=float("nan")), "seed must be a whole number from 0"),
        (TryEmptying(seed=2**31 - 1), "seed must be a whole number from 0"),
        (TryEmptying(seen="guessed"), "seen 'guessed' is not known; there are truth, scan"),
        (TryEmptying(changes=("colours",)), "kind of change 'colours' is not known; there are"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(line, command, says):
    assert says in refused(line, command)
    assert not line.effects


def test_it_is_for_engineers_and_waits_for_control_and_for_the_robot(samples, cell):
    line = planned_line(samples, cell)
    with pytest.raises(NotAllowed, match="emptying piles in simulation is for engineers"):
        check_allowed(line.state, TryEmptying(), "ada", line.now, role=Role.OPERATOR)
    controlled = replace(line.state, control="bob")
    assert "bob is in control" in str(lacks_right(controlled, TryEmptying, "ada", Role.ENGINEER))
    line.state = replace(line.state, phase=Phase.SENDING)
    assert "not possible now" in refused(line, TryEmptying())


def test_one_that_is_cancelled_or_fails_leaves_the_result_before(line, cell):
    found = emptied(cell)
    line.do(TryEmptying())
    line.ended(found)
    line.do(TryEmptying())
    number = line.state.job.number
    line.do(CancelJob())
    assert isinstance(line.effects[-1], StopJob) and line.state.job is None
    # What it brings all the same is on record, and not used.
    line.do(JobEnded(number, emptied(cell, "late")), WORKER)
    assert line.state.emptying is found
    for error in (JobCancelled("the emptying was cancelled"), InputError("they do not fit")):
        line.do(TryEmptying())
        line.ended(error)
        assert line.state.emptying is found and line.state.job is None
    assert "they do not fit" in str(line.state.message)

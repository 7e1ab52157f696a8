"""Parts of a simulated pile stay until they are picked, or new ones are asked for."""

from dataclasses import replace

import pytest
from line import Line, send

from workbench.app.core.cell.bins import NewBin
from workbench.app.core.command import Entry
from workbench.app.core.cycle.outcomes import AcknowledgeFault, ReportPick, parts_sent_for
from workbench.app.core.cycle.scanning import USUAL_PARTS, TakeScan, left_pile, scan_of_pile
from workbench.app.core.cycle.sending import LinkEnded
from workbench.app.core.decide import decide

FOUR = TakeScan(seed=3, parts=4, stays=True)


@pytest.fixture
def line(cell) -> Line:
    return Line(cell)


@pytest.fixture
def sent(line, samples):
    """Four parts have fallen; a plan for one of them is on its way."""
    line.do(FOUR)
    line.ended(samples.scan())
    pile = line.state.pile
    send(line, samples, FOUR)
    assert line.state.pile.name == pile.name and line.state.pile.lifted == ()
    return line


def lifted(line, command=FOUR):
    """The poses that the next scan is to take out of the pile."""
    _, effects = decide(line.state, Entry(line.state.number + 1, line.now, "ada", command))
    return effects[0].arguments.get("lifted", ())


def test_a_picked_part_is_gone_from_the_next_scan_and_from_those_after(sent, samples):
    numbers = [number for number, _ in parts_sent_for(sent.state)]
    places = [sent.state.plan.detections[number].T_world_part for number in numbers]
    sent.do(LinkEnded(parts_placed=len(places)))
    assert places and all(T.isApprox(P) for T, P in zip(lifted(sent), places, strict=True))
    sent.do(FOUR)
    sent.ended(samples.scan())
    assert sent.state.pile.left == 4 - len(places)
    assert len(lifted(sent)) == len(places), "also in the scan after that"
    assert lifted(sent, TakeScan(seed=4, parts=4, stays=True)) == ()
    assert lifted(sent, TakeScan(seed=3, parts=4)) == (), "who asks for no rest gets a whole pile"


def test_a_part_that_the_hand_did_not_hold_stays(sent):
    numbers = [number for number, _ in parts_sent_for(sent.state)]
    sent.do(LinkEnded(parts_placed=0))
    for number in numbers:
        sent.do(ReportPick(number, False))
    assert lifted(sent) == () and left_pile(sent.state, FOUR).left == 4


def test_after_a_fault_only_what_was_reported_is_gone(sent):
    sent.do(LinkEnded("the link broke"))
    assert lifted(sent) == ()
    number = parts_sent_for(sent.state)[0][0]
    sent.do(ReportPick(number, True))
    assert len(lifted(sent)) == 1
    sent.do(AcknowledgeFault())
    assert len(lifted(sent)) == 1


def test_once_all_parts_are_gone_the_pile_falls_again(line, samples):
    two = TakeScan(seed=3, parts=1, stays=True)
    send(line, samples, two)
    line.do(LinkEnded(parts_placed=1))
    assert left_pile(line.state, two) is None and lifted(line, two) == ()


def test_a_rescan_before_any_pick_shows_the_same_parts(line, samples):
    line.do(FOUR)
    line.ended(samples.scan())
    assert lifted(line) == () and left_pile(line.state, FOUR).left == 4


def test_a_scan_without_a_seed_is_of_what_is_left_and_then_of_new_parts(line, samples):
    first = scan_of_pile(line.state)
    assert (first.parts, first.stays) == (USUAL_PARTS, True)
    send(line, samples, TakeScan(seed=3, parts=2, stays=True))
    line.do(LinkEnded(parts_placed=1))
    again = scan_of_pile(line.state)
    assert (again.seed, again.parts) == (3, 2) and len(lifted(line, again)) == 1
    for other in (scan_of_pile(line.state, 5), scan_of_pile(line.state, drops_new=True)):
        assert other.seed != 3 and lifted(line, other) == ()
    send(line, samples, TakeScan(seed=3, parts=1, stays=True))
    line.do(LinkEnded(parts_placed=1))
    assert scan_of_pile(line.state).seed != 3, "nothing is left of it"


def test_a_bin_that_was_refilled_has_new_parts(cell, samples):
    other = replace(cell.bin, name="other")
    line = Line(replace(cell, bin=replace(cell.bin, name="here"), other_bins=(other,)))
    line.do(FOUR)
    line.ended(samples.scan())
    line.do(NewBin("other"))
    assert line.state.pile is not None, "it is the other bin"
    line.do(NewBin("here"))
    assert line.state.pile is None and scan_of_pile(line.state).seed != FOUR.seed

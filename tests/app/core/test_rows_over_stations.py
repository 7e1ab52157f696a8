"""Two plans that bring one part over a station: not parted, counted once, and never forgotten."""

from dataclasses import replace

from line import Line, refused

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.rows import ShortenRow
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import Send
from workbench.app.core.state import Phase
from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import Proven
from workbench.model.release import PartReport

PICKED = (PartReport("right", 0, True),)


def planned(samples) -> Line:
    line = Line(samples.cell)
    line.joints = {"joint_1": 0.0}
    line.do(TakeScan())
    scan = samples.scan()
    line.ended(scan)
    line.do(FindParts())
    line.ended(samples.row(scan.digest).plan.detections)
    line.do(MakePlan(threshold=0.2))
    line.ended(samples.row(scan.digest, picks=2))
    return line


def digests(line: Line) -> tuple[str, tuple[str, ...]]:
    return line.state.plan.digest, tuple(one.plan.digest for one in line.state.row)


def sent(line: Line) -> list[str]:
    return [one.plan.digest for one in line.effects if isinstance(one, Send)]


def ends(line: Line, **otherwise) -> None:
    line.do(replace(LinkEnded("", 1, PICKED, ()), **otherwise))


def over_a_station(samples, *, stays=False) -> Line:
    """Two plans: the first puts the part on a station, from where the second takes it."""
    line = planned(samples)
    state = line.state
    assert state.plan is not None
    first, (one,) = state.plan, state.row
    first = replace(
        first,
        detections=first.detections[:1],
        arms=(replace(first.arms[0], station="post"),),
    )
    stands = replace(
        first.detections[0],
        T_world_part=pose_from_rpy((0.5, 0.5, 0.1)),
        T_world_found=None if stays else first.detections[0].T_world_part,
    )
    second = replace(one.plan, detections=(stands,))
    line.state = replace(
        state,
        plan=first,
        proof=samples.proof(first),
        row=(Proven(second, samples.proof(second)),),
        detections=first.detections,
    )
    return line


def sending_over_a_station(samples) -> Line:
    line = over_a_station(samples)
    plan, row = digests(line)
    line.do(WatchPlan(plan, row=row))
    line.do(Approve(plan, row=row))
    line.effects.clear()
    line.do(SendPlan(plan))
    return line


def test_a_part_over_a_station_is_one_part(in_rows):
    line = sending_over_a_station(in_rows)
    on_station = replace(line.state.row[0].plan.detections[0], T_world_found=None)
    ends(line, placed=(on_station,))
    assert line.state.phase is Phase.SENDING
    assert line.state.placed == (on_station,), "nothing else is put there meanwhile"
    ends(line, placed=())
    assert line.state.phase is Phase.DONE and line.state.parts_placed == 1
    assert "1 of 1 part reported placed" in str(line.state.message)
    assert [one.detection for one in line.state.outcomes] == [0]
    assert line.state.placed == ()


def test_a_part_that_was_not_picked_is_not_taken_from_the_station(in_rows):
    line = sending_over_a_station(in_rows)
    ends(line, parts=(PartReport("right", 0, False, "nothing held"),), parts_placed=0)
    assert line.state.phase is Phase.DONE and len(sent(line)) == 1
    assert "after 1 of 2 plans" in str(line.state.row_ends) and "nothing held" in str(
        line.state.row_ends
    )
    assert "check whether a part is on station post; take it away" in str(line.state.row_ends)


def test_a_part_that_stays_on_the_station_is_remembered(in_rows):
    line = sending_over_a_station(in_rows)
    on_station = replace(line.state.row[0].plan.detections[0], T_world_found=None)
    line.do(Stop(), "bob")
    ends(line, placed=(on_station,))
    assert line.state.phase is Phase.DONE and line.state.placed == (on_station,)
    assert "stopped by bob; check whether a part is on station post" in str(line.state.message)


def test_a_part_that_was_dropped_on_its_way_from_the_station_may_still_be_there(in_rows):
    line = sending_over_a_station(in_rows)
    on_station = replace(line.state.row[0].plan.detections[0], T_world_found=None)
    ends(line, placed=(on_station,))
    ends(line, placed=(), parts=(PartReport("right", 0, False, "nothing held"),), parts_placed=0)
    assert line.state.placed == (on_station,)
    assert [(one.detection, one.is_picked) for one in line.state.outcomes] == [(0, False)]


def test_two_plans_over_a_station_are_not_parted(in_rows):
    line = over_a_station(in_rows)
    plan, row = digests(line)
    assert "plan 1 puts a part on station post" in refused(line, ShortenRow(plan, 1))
    line.do(WatchPlan(plan, row=row))
    whole = line.state
    line.state = replace(whole, row=())
    assert "no plan that follows takes it from there" in refused(line, Approve(plan))
    line.state = whole
    line.do(Approve(plan, row=row))
    line.state = replace(line.state, row=())
    assert "for another row of plans" in refused(line, SendPlan(plan))


def test_a_plan_that_takes_another_part_leaves_the_one_on_the_station(in_rows):
    line = over_a_station(in_rows, stays=True)
    plan, row = digests(line)
    line.do(WatchPlan(plan, row=row))
    assert "puts a part on station post" in refused(line, Approve(plan, row=row))

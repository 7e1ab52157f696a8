"""A click on the place where a plan comes nearest to something shows it, to whoever approves."""

from contextlib import nullcontext
from types import SimpleNamespace

from workbench.app.core.commands import (
    FindParts,
    JobEnded,
    MakePlan,
    TakeControl,
    UseScan,
)
from workbench.app.core.people import Person, Role
from workbench.app.picking.facts import nearest_place
from workbench.gui.scene.nearest import PlanLinks
from workbench.gui.shared.playback import timeline


def test_who_is_not_in_control_but_approves_sees_it(visitor, bench, scan, detections, result):
    bench.do(UseScan(scan), "Ada")
    bench.do(JobEnded(bench.do(FindParts(), "Ada").number, detections), "worker")
    bench.do(JobEnded(bench.do(MakePlan(), "Ada").number, result), "worker")
    bench.do(TakeControl(), "Ada")
    visitor.person = Person("Bob", Role.OPERATOR)
    visitor.client.camera = SimpleNamespace()
    visitor.client.atomic = nullcontext
    end = result.plan.cycle_seconds
    visitor.look._look.change(candidate=0, time=end)
    PlanLinks(visitor)._go()
    look = visitor.look.now
    near = result.proof.nearest
    (run,) = [
        one for one in timeline(result.plan) if (one.arm, one.leg.name) == (near.arm, near.leg)
    ]
    spot = nearest_place(bench.state.cell, result.plan, result.proof)
    assert look.time == visitor.own.now.visited.time == run.start + spot.seconds < end
    assert look.candidate is None and not look.follows

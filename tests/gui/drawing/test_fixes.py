"""The nearest fix is looked for beside the drawing, and only for what is still looked at."""

import threading
from dataclasses import replace

from waiting import PATIENCE, wait_until

import workbench.gui.drawing.fixes
from workbench.gui.drawing.fixes import LOOKING, FixFinder
from workbench.gui.shared.look import NO_HELP
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.planning.picking.nearest_fix import fix_words, nearest_fix


def test_candidates_of_a_plan_before_are_not_tried_any_more(states, monkeypatch):
    go_on, tried = threading.Event(), []

    def slow(cell, detections, candidates, **_):
        tried.append(candidates[0].rank)
        assert go_on.wait(PATIENCE)

    monkeypatch.setattr(workbench.gui.drawing.fixes, "nearest_fix", slow)
    refused = Verdict(Reason.IN_COLLISION, Stage.GRASP, ("palm", "bin_wall_back"), -0.01)
    one = replace(states.planned.candidates[0], verdict=refused)
    old = replace(states.planned, candidates=tuple(replace(one, rank=k) for k in (0.0, 1.0, 2.0)))
    new = replace(old, candidates=(replace(one, rank=9.0),))
    found = threading.Semaphore(0)
    fixes = FixFinder(found.release)
    assert [fixes.of(old, k) for k in range(3)] == [LOOKING] * 3
    assert fixes.of(new, 0) == LOOKING
    go_on.set()
    while fixes.of(new, 0) == LOOKING:
        assert found.acquire(timeout=PATIENCE)
    assert fixes.of(new, 0).words == fix_words(None)
    assert tried == [0.0, 9.0]
    fixes.close()


def test_where_nothing_can_be_taken_the_best_help_of_all_is_named(states):
    """In the words of the command `explain`; with a plan nothing has to help."""
    fixes = FixFinder(lambda: None)
    refused = [c for c in states.planned.candidates if c.verdict.pair is not None]
    assert fixes.without_plan(states.planned) is NO_HELP
    state = replace(states.localized, candidates=tuple(refused))
    wait_until(lambda: fixes.without_plan(state) not in (NO_HELP, LOOKING), "what helps")
    fix = nearest_fix(state.cell, state.detections, state.candidates, seed=0)
    told = fixes.without_plan(state)
    assert told.words == fix_words(fix)
    assert (told.fix is None) == (fix is None)
    fixes.close()

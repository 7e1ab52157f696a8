"""How sure a candidate is, is worked out beside the drawing, once for each that is looked at."""

from dataclasses import replace

from waiting import wait_until

import workbench.gui.drawing.sureness
from workbench.gui.drawing.sureness import Sureness
from workbench.planning.placing.budget import budget_of


def test_it_says_of_the_chosen_candidate_what_its_budget_says(states):
    state = states.planned
    sureness = Sureness(lambda: None)
    assert sureness.of(state, None) is None
    assert sureness.of(state, len(state.candidates)) is None
    wait_until(lambda: sureness.of(state, 1), "what is said of it")
    candidate = state.candidates[1]
    budget = budget_of(state.cell, state.detections[candidate.detection], candidate)
    assert sureness.of(state, 1) == budget.words
    sureness.close()


def test_a_candidate_whose_part_is_gone_says_nothing(states):
    sureness = Sureness(lambda: None)
    assert sureness.of(replace(states.planned, detections=()), 0) is None
    sureness.close()


def test_one_of_which_nothing_can_be_said_leaves_the_page_as_it_is(states, monkeypatch):
    tried = []

    def fails(cell, detection, candidate, bases):
        tried.append(candidate)
        raise ValueError

    monkeypatch.setattr(workbench.gui.drawing.sureness, "budget_of", fails)
    woken = []
    sureness = Sureness(lambda: woken.append(1))
    assert sureness.of(states.planned, 0) is None
    wait_until(lambda: woken, "the end of the try")
    assert sureness.of(states.planned, 0) is None and len(tried) == 1
    sureness.close()

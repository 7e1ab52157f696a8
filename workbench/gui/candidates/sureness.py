"""How sure it is where the chosen candidate's part comes to lie, in words."""

from functools import lru_cache

from workbench.gui.shared.look import View
from workbench.model.candidate import Candidate
from workbench.model.cell import Cell
from workbench.model.scan import Detection
from workbench.planning.placing.budget import budget_of


def sureness_words(view: View) -> str:
    """What is said of the chosen candidate; empty where none is chosen."""
    state, number = view.state, view.look.candidate
    candidates, detections = state.candidates or (), state.detections or ()
    if number is None or number >= len(candidates):
        return ""
    candidate = candidates[number]
    if candidate.detection >= len(detections):
        return ""
    return _words(state.cell, detections[candidate.detection], candidate)


@lru_cache(maxsize=256)
def _words(cell: Cell, detection: Detection, candidate: Candidate) -> str:
    """Once for all browsers."""
    return budget_of(cell, detection, candidate).words

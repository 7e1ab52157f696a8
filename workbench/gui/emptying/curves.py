"""How the piles went empty: parts taken over picks, a curve for each pile."""

from collections.abc import Sequence

import numpy as np

from workbench.gui.shared.colours import JOINTS
from workbench.gui.shared.plots import Curve, Plot
from workbench.gui.texts.emptying import EmptyingText
from workbench.model.prediction import EmptiedPile
from workbench.words.words import IN_ENGLISH, Words

MOST_CURVES = len(JOINTS)
"""As many piles have a colour of their own; the others are not drawn."""

FEWEST_PICKS = 5.0
"""Picks on the axis at least."""


def taken_plot(piles: Sequence[EmptiedPile], words: Words = IN_ENGLISH) -> Plot:
    """Parts taken after each pick, from none on; a failed pick makes a curve level.

    A curve ends with the last pick of its pile.
    """
    shown = piles[:MOST_CURVES]
    most = max((len(pile.outcomes) for pile in shown), default=0)
    curves = tuple(
        Curve(
            words.render(EmptyingText.SEED(seed=pile.task.seed)),
            JOINTS[number],
            _count_taken(pile, most),
        )
        for number, pile in enumerate(shown)
    )
    title = EmptyingText.CURVES()
    if len(piles) > len(shown):
        title = EmptyingText.CURVES_FIRST(count=len(shown))
    high = float(max((pile.parts for pile in shown), default=1))
    return Plot(words.render(title), "parts", np.arange(most + 1.0), curves, 0.0, high, "pick")


def end_of(plot: Plot) -> float:
    """Where the axis of the picks ends: with room for its name, and whole numbers on it."""
    return 1.1 * max(float(plot.times[-1]), FEWEST_PICKS)


def _count_taken(pile: EmptiedPile, most: int) -> np.ndarray:
    taken = np.full(most + 1, np.nan)
    steps = [not outcome for outcome in pile.outcomes]
    taken[: len(steps) + 1] = np.cumsum([0, *steps])
    return taken

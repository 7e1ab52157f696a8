"""What a study of many piles says about a threshold: to be looked at before one is chosen."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Forecast:
    """What to expect where both arms may take parts at least `threshold` [m] apart at once.

    Shares are 0..1, None where nothing was counted: of the pairs that may be taken at once, and of
    the pairs with a proven plan.  `planning` and `cycle` [s]: the median and the mean for a pair.
    """

    threshold: float
    coordinated: float | None
    success: float | None
    planning: float | None
    cycle: float | None
    parts_per_hour: float | None


@dataclass(frozen=True, slots=True)
class Predictions:
    """The forecasts of one study of so many piles, made with the cell that has this digest."""

    cell_digest: str
    piles: int
    forecasts: tuple[Forecast, ...]

    def near(self, threshold: float) -> Forecast | None:
        """The forecast for the threshold [m] that is nearest to this one."""
        return min(self.forecasts, key=lambda one: abs(one.threshold - threshold), default=None)

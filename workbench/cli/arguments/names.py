"""Choices that several commands offer; repeated here because `--help` loads nothing heavy."""

from typing import Literal

StrategyName = Literal["auto", "alternated", "coordinated", "right", "left", "both"]
OrderName = Literal["travel", "highest", "score", "nearest", "walls", "thesis"]

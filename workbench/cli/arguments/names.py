"""Choices that several commands offer; repeated here because `--help` loads nothing heavy."""

from typing import Literal

OrderName = Literal["travel", "highest", "score", "nearest", "walls", "thesis"]

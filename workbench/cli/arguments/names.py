"""Choices that several commands offer; repeated here because `--help` loads nothing heavy."""

from typing import Literal

ProtocolName = Literal["abb-socket", "abb-socket/2"]
OrderName = Literal["travel", "highest", "score", "nearest", "walls", "thesis"]
PlannerName = Literal[
    "rrtconnect",
    "birrt",
    "rrt",
    "sbl",
    "prmstar",
    "bitstar",
    "lbkpiece",
    "informed-rrtstar",
    "aorrtc",
]

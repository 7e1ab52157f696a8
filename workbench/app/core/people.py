"""People, and machines beside them: who asks for what, what they are there for, and control."""

from dataclasses import dataclass
from enum import StrEnum

WORKER = "worker"
ROBOT_LINK = "robot link"
CELL_FILE = "cell file"
POSES_FOLDER = "poses folder"
FRONT_DOOR = "front door"
SESSION_START = "session start"
MACHINES = frozenset({WORKER, ROBOT_LINK, CELL_FILE, POSES_FOLDER, FRONT_DOOR, SESSION_START})
"""Actors that are not people; only they report what happened, and they may do nothing else."""

NOBODY = "operator"
"""Who acts in a browser without a login; an approval always has a name of its own."""


class Role(StrEnum):
    """What a person is there for; each may do all that the one before may."""

    VIEWER = "viewer"
    """Looks."""
    OPERATOR = "operator"
    """Scans, plans, approves, runs."""
    ENGINEER = "engineer"
    """Edits cell, parts and grasps too, and takes control over from others."""

    @property
    def said(self) -> str:
        """With its article, as sentences have it."""
        return f"{'a' if self is Role.VIEWER else 'an'} {self}"

    def covers(self, other: "Role") -> bool:
        """Whether who has this role may do what the other one may."""
        order = tuple(Role)
        return order.index(self) >= order.index(other)


@dataclass(frozen=True, slots=True)
class Person:
    """Somebody who has said who they are."""

    name: str
    role: Role


@dataclass(frozen=True, slots=True, eq=False)
class AskForControl:
    """A person would like to be in control; who is may hand it over, or keep it."""


@dataclass(frozen=True, slots=True, eq=False)
class TakeControl:
    """A person is in control from now on: nobody was, or an engineer takes it over."""


@dataclass(frozen=True, slots=True, eq=False)
class GiveControl:
    """Hand control over to somebody who has asked for it."""

    to: str


@dataclass(frozen=True, slots=True, eq=False)
class DenyControl:
    """Keep control: what `to` has asked for is answered with no."""

    to: str


@dataclass(frozen=True, slots=True, eq=False)
class ReleaseControl:
    """Nobody is in control any more.

    `of` is whose it was when that person's last browser has gone, as the front door saw it;
    empty: of the one who gives this.
    """

    of: str = ""

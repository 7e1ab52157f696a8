"""People and machines that give commands, their roles, and who is in control."""

import unicodedata
from dataclasses import dataclass
from enum import StrEnum

from workbench.model.messages.commands import RoleText
from workbench.model.messages.message import Message

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
    """What a person may do; each role includes the one before."""

    VIEWER = "viewer"
    """Looks."""
    OPERATOR = "operator"
    """Scans, plans, approves, runs."""
    ENGINEER = "engineer"
    """Edits cell, parts and grasps too, and takes control over from others."""

    @property
    def message(self) -> Message:
        """Its name for people."""
        return RoleText[self.name]()

    @property
    def said(self) -> RoleText:
        """One person of it, as sentences have it."""
        return RoleText.A_VIEWER if self is Role.VIEWER else RoleText[f"AN_{self.name}"]

    @property
    def several(self) -> RoleText:
        """All people of it, as sentences have them."""
        return RoleText[f"{self.name}S"]

    def covers(self, other: "Role") -> bool:
        """Whether who has this role may do what the other one may."""
        order = tuple(Role)
        return order.index(self) >= order.index(other)


@dataclass(frozen=True, slots=True)
class Person:
    """A person with a name."""

    name: str
    role: Role


def is_same_person(first: str, second: str) -> bool:
    """Whether two names are one: case, spaces and ways to write a letter make no other person."""
    return fold_name(first) == fold_name(second)


def fold_name(name: str) -> str:
    """A name without what makes no other person of it."""
    return " ".join(unicodedata.normalize("NFKC", name).casefold().split())

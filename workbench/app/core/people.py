"""People: who asks for something, and what they are there for."""

from dataclasses import dataclass
from enum import StrEnum


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

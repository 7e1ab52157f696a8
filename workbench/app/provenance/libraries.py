"""Shared libraries that are no Python packages, and what installs them."""

from dataclasses import dataclass

from workbench.devices.genicam.library import INSTALLS, LIBRARY, is_installed


@dataclass(frozen=True, slots=True)
class Library:
    """One of them: what asks for it, whether it is here, and the command that installs it."""

    name: str
    use: str
    is_here: bool
    installs: str


def libraries() -> tuple[Library, ...]:
    """All that the workbench can use."""
    return (Library(LIBRARY, "the scanner genicam", is_installed(), INSTALLS),)

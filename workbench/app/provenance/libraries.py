"""Shared libraries that are no Python packages, and what installs them."""

from dataclasses import dataclass

from workbench.model.errors import InputError
from workbench.plugins.extras import from_extra


@dataclass(frozen=True, slots=True)
class Library:
    """One of them: what asks for it, whether it is here, and the command that installs it."""

    name: str
    use: str
    is_here: bool
    installs: str


def libraries() -> tuple[Library, ...]:
    """All that the installed extras can use."""
    try:
        return from_extra("genicam.library:libraries")()
    except InputError:
        return ()

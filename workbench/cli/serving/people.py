"""Who may come in, as what is recorded of a start has it."""

from collections.abc import Mapping
from contextlib import closing
from pathlib import Path

from workbench.web.access.store import Store
from workbench.web.access.users import Users


def roles(path: Path) -> Mapping[str, str]:
    """The users in a file (name -> role), those who are kept out left out; empty without a file.

    Raises:
        FileError: it cannot be read.
    """
    if not path.exists():
        return {}
    with closing(Store(path)) as store:
        return {user.name: str(user.role) for user in Users(store).all() if not user.is_disabled}

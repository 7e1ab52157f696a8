"""What can be typed after `workbench rapid`; the docstrings are the help."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tyro.conf import Positional

from workbench.cli.arguments.names import Json


@dataclass(frozen=True, slots=True)
class RapidCommands:
    """Check modules in RAPID: syntax, names, types, bounds, and what is never reached.

    A folder with a controller.toml is checked task by task; files alone are one task.  What
    `workbench controller --rapid` cannot run is a problem, too.  Succeeds when there is none.
    """

    what: Positional[Literal["check"]]
    """What to do with them."""
    paths: Positional[tuple[Path, ...]]
    """Folder, as robots/yumi/rapid, or files of one task."""
    signal: tuple[str, ...] = ()
    """Names of outputs that the controller has."""
    json: Json = False

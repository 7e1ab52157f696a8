"""What can be typed after `workbench rapid`; the docstrings are the help."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tyro.conf import Positional

from workbench.cli.arguments.names import Json


@dataclass(frozen=True, slots=True)
class RapidCommands:
    """Check modules in RAPID, a customer's backup for example, without running them.

    Three findings: what is wrong, with file and line; names that are not known here, since an
    add-in, a signal or another task has them; what RobotWare has and `workbench controller --rapid`
    does not execute.

    A folder with a controller.toml is checked task by task, a backup as its folders, EIO.cfg and
    SYS.cfg say; other files are one task, or one for each main.

    Exit codes: 0 nothing is wrong, 3 something is, 2 a file cannot be read as RAPID.
    """

    what: Positional[Literal["check"]]
    """What to do with them."""
    paths: Positional[tuple[Path, ...]]
    """Folders, as a backup or robots/yumi/rapid, or files."""
    signal: tuple[str, ...] = ()
    """Names of outputs that the controller has, or of other signals: NAME:DI, GO, AI and so on."""
    beside: Path | None = None
    """Folder of modules that are to be added, as robots/yumi/rapid: what clashes, what to call."""
    json: Json = False

"""The seam of extras: what the core starts by name, and does without where it is not asked for."""

import importlib
import shlex
import sys
from pathlib import Path
from typing import Any

from workbench.model.errors import InputError

SHELF = "workbench.extras"

LIBRARIES = {"mcap": "mcap", "modbus": "pymodbus", "opcua": "asyncua"}
"""The library that an extra needs, if any, and that `install_command` brings."""


def install_command(extra: str) -> str:
    """The command that installs what an extra needs into the environment that runs.

    PyPI's `workbench` is another project, which the `pip` of another environment would install.

    Args:
        extra: by its name; empty for the core.
    """
    what = f"workbench[{extra}]" if extra else "workbench"
    return shlex.join((sys.executable, "-m", "pip", "install", what))


def not_installed() -> InputError:
    """The error of a checkout that runs without its metadata; it names the command that helps."""
    checkout = Path(__file__).parents[2]
    command = shlex.join((sys.executable, "-m", "pip", "install", str(checkout)))
    return InputError(f"the workbench is not installed: {command}")


def from_extra(target: str, who: str = "this needs") -> Any:
    """A function of an extra.

    Args:
        target: `extra.module:function`.
        who: asks for it, as a sentence begins that says what is missing: "--opcua needs".

    Raises:
        InputError: the extra, or a library that it needs, is not installed.
        ModuleNotFoundError: the extra is there, but names no module of ours.
    """
    module, _, name = target.partition(":")
    extra = module.partition(".")[0]
    try:
        return getattr(importlib.import_module(f"{SHELF}.{module}"), name)
    except ModuleNotFoundError as error:
        missing = (error.name or "").partition(".")[0]
        is_whole = f"{SHELF}.{extra}".startswith(error.name or "")
        if missing == "workbench" and not is_whole:
            raise
        library = LIBRARIES.get(extra) if is_whole else missing
        if library is None:
            says = f"{SHELF}.{extra}, which is not installed"
        elif extra in LIBRARIES:
            says = f"the library {library}: {install_command(extra)}"
        else:
            says = f"the library {library}, which is not installed"
        raise InputError(f"{who} {says}") from error

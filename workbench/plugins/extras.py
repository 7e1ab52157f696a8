"""The seam of extras: what the core starts by name, and does without where it is not asked for."""

import importlib
from typing import Any

from workbench.model.errors import InputError

SHELF = "workbench.extras"

LIBRARIES = {"mcap": "mcap", "modbus": "pymodbus", "opcua": "asyncua"}
"""The library that an extra needs, if any, and that `pip install 'workbench[extra]'` brings."""


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
        library, missing = LIBRARIES.get(extra), error.name or ""
        is_whole = f"{SHELF}.{extra}".startswith(missing)
        if library is not None and (is_whole or missing.partition(".")[0] == library):
            says = f"the library {library}: pip install 'workbench[{extra}]'"
        elif is_whole:
            says = f"{SHELF}.{extra}, which is not installed"
        elif missing.startswith("workbench"):
            raise
        else:
            says = f"the library {missing}, which is not installed"
        raise InputError(f"{who} {says}") from error

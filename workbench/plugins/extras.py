"""The seam of extras: what the core starts by name, and does without where it is not asked for."""

import importlib
from typing import Any

from workbench.model.errors import InputError

SHELF = "workbench.extras"

LIBRARIES = {"mcap": "mcap", "modbus": "pymodbus", "opcua": "asyncua"}
"""The library that an extra needs, if any, and that `pip install 'workbench[extra]'` brings."""


def from_extra(target: str, who: str) -> Any:
    """A function of an extra.

    Args:
        target: `extra.module:function`.
        who: asks for it, as a sentence begins that says what is missing: "--opcua needs".

    Raises:
        InputError: the extra, or a library that it needs, is not installed.
    """
    module, _, name = target.partition(":")
    try:
        return getattr(importlib.import_module(f"{SHELF}.{module}"), name)
    except ModuleNotFoundError as error:
        raise InputError(f"{who} {needed(module.partition('.')[0])}") from error


def needed(extra: str) -> str:
    """What to install for an extra, as a sentence ends that says what is missing."""
    if extra not in LIBRARIES:
        return f"{SHELF}.{extra}, which is not installed"
    return f"the library {LIBRARIES[extra]}: pip install 'workbench[{extra}]'"

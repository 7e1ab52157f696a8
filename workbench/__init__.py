"""Workbench: plan, prove, approve and run robotic bin picks from a web page, or from Python.

What programs use stands in `workbench.api`; it is loaded when a name of it is first asked for, so
that commands which need nothing of it start at once.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from workbench.environment import prepare

if TYPE_CHECKING:
    from workbench.api import *  # noqa: F403

__version__ = "1.0.0"

prepare()


def __getattr__(name: str) -> Any:
    if name == "__all__" or not name.startswith("_"):
        api = import_module("workbench.api")
        if name == "__all__" or name in api.__all__:
            return getattr(api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *import_module("workbench.api").__all__})

"""Compiling of functions that make no array: what counts where a path is searched.

The proof has a module of its own for it, since both share nothing.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Function = TypeVar("Function", bound=Callable[..., object])

IN_PLACE: dict[str, Any] = {"cache": True, "_nrt": False}
"""`_nrt`: numba's counting of references.  A call counts every array of its arguments, up and down;
for a check of an edge that took longer than the check itself."""


def njit_in_place(function: Function) -> Function:
    """Compile a function that writes into arrays it is handed, makes none, and returns numbers.

    It takes no generator, which would never be released, and calls only functions like itself:
    numba refuses one that makes an array, unless that was compiled before.
    """
    return cast(Function, njit(**IN_PLACE)(function))

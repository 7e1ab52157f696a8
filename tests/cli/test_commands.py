"""Whatever can be typed is carried out by a function that takes just that."""

from importlib import import_module
from typing import Any, get_args, get_type_hints

import pytest

from workbench.cli.arguments import top
from workbench.cli.main import HOW, OF_EXTRAS


def kinds_in(union: Any) -> list[type]:
    return [get_args(one)[0] for one in get_args(union)]


def typed_commands() -> list[type]:
    found: list[type] = []
    for kind in kinds_in(top.Arguments):
        what = get_type_hints(kind, include_extras=True).get("what")
        is_nested = kind not in (*HOW, *OF_EXTRAS) and what is not None
        found += kinds_in(what) if is_nested else [kind]
    return found


def test_there_is_a_function_for_everything_that_can_be_typed_and_no_other():
    assert sorted(typed_commands(), key=str) == sorted((*HOW, *OF_EXTRAS), key=str)


@pytest.mark.parametrize(
    ("kind", "place"), HOW.items(), ids=lambda one: getattr(one, "__name__", "")
)
def test_the_function_takes_what_was_typed(kind, place):
    module, _, name = place.partition(":")
    hints = get_type_hints(getattr(import_module(f"workbench.cli.{module}"), name))
    assert hints == {"typed": kind, "return": int}

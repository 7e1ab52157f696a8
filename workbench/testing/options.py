"""The promises of a plug-in's own keys in the cell file."""

import dataclasses
from typing import Any

from workbench.model.errors import InputError
from workbench.plugins.options import Options, options_of, schema_of


def check_options(kind: type, given: Options | None = None) -> Any:
    """The keys of a plug-in can be checked, shown in a schema, and refuse what nobody knows.

    Args:
        kind: the plug-in's `Options`.
        given: values for the keys that have to be given.

    Returns:
        The options made of what was given.
    """
    given = given or {}
    made = options_of(kind, given)
    form = schema_of(kind)
    assert set(form["required"]) <= set(given), "a key that has to be given was not"
    if dataclasses.is_dataclass(kind):
        assert kind.__dataclass_params__.frozen, "options are values: make them frozen"  # type: ignore[attr-defined]
    try:
        options_of(kind, {**given, "no such key": 1})
    except InputError:
        return made
    raise AssertionError("a key that nobody knows was taken")

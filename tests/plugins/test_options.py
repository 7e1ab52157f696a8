"""The keys of a plug-in's own: checked with a word on what is wrong, and shown."""

from dataclasses import dataclass

import jsonschema
import pytest

from workbench.model.errors import InputError
from workbench.plugins.options import NoOptions, option, options_of, schema_of
from workbench.testing import check_options


@dataclass(frozen=True)
class Some:
    """Of each kind one."""

    address: str
    gain: float = option(1.5, low=0.0, high=10.0, says="of the camera")
    tries: int = option(3, low=1)
    mode: str = option("fast", among=("fast", "fine"))
    is_dark: bool = False


def test_values_are_taken_and_the_others_are_the_usual():
    made = options_of(Some, {"address": "a", "gain": 2})
    assert made == Some("a", 2.0) and isinstance(made.gain, float)
    check_options(Some, {"address": "a"})
    check_options(NoOptions)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({}, "address is missing; a text is expected"),
        ({"address": "a", "gian": 1.0}, "gian is not known here (known: address, gain"),
        ({"address": 4}, "address: a text is expected, 4 is given"),
        ({"address": "a", "gain": 11.0}, "gain: 11.0 is not between 0 and 10"),
        ({"address": "a", "gain": float("nan")}, "gain: nan is not between"),
        ({"address": "a", "gain": 10**400}, "is not between 0 and 10"),
        ({"address": "a", "tries": 10**400}, "is not between 1 and inf"),
        ({"address": "a", "gain": True}, "gain: a number is expected"),
        ({"address": "a", "tries": 1.5}, "tries: a whole number is expected"),
        ({"address": "a", "mode": "slow"}, "mode: 'slow' is not one of fast, fine"),
        ({"address": "a", "is_dark": 1}, "is_dark: true or false is expected"),
    ],
)
def test_what_does_not_fit_is_refused_with_a_reason(given, says):
    with pytest.raises(InputError) as error:
        options_of(Some, given)
    assert says in str(error.value)


def test_the_schema_says_the_same():
    form = schema_of(Some)
    jsonschema.Draft202012Validator.check_schema(form)
    jsonschema.validate({"address": "a", "gain": 2, "mode": "fine"}, form)
    for wrong in ({}, {"address": "a", "gain": 11}, {"address": "a", "x": 1}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(wrong, form)
    assert form["properties"]["gain"]["description"] == "of the camera"
    assert schema_of(NoOptions)["properties"] == {}

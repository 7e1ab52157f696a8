"""The way back from canonical form (`model.digest`) to values, and the arrays beside it.

In canonical form a large array stands as shape, type and the SHA-256 of its bytes.  Those
bytes are the content of a file with that digest, so form and files together are the value.
"""

import dataclasses
import enum
import functools
import hashlib
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING
from typing import Any, cast

import numpy as np
import pinocchio as pin

from workbench.model.cell import Controller
from workbench.model.digest import LARGE, canonical, digest_of
from workbench.model.messages.catalogue import message_of
from workbench.model.messages.message import Message
from workbench.model.plan import Strategy
from workbench.plugins.robot_link import link_named

Content = bytes | memoryview

ReadFile = Callable[[str], Content]
"""SHA-256 -> content."""


PLAIN = frozenset({str, int, float, bool})
"""Types that JSON has."""


def large_arrays(value: Any) -> dict[str, memoryview]:
    """The bytes of all arrays in a value that its canonical form names by digest only.

    None is copied: no other thread runs while Python copies bytes, and scans have many.
    """
    found: dict[str, memoryview] = {}
    _collect(value, found)
    return found


def restore_value(kind: Any, form: Any, read: ReadFile) -> Any:
    """The value of type `kind` whose canonical form this is.

    Args:
        kind: a type or annotation as it stands in the model's dataclasses.
        form: canonical form, as JSON gives it back.
        read: gives the files for large arrays.

    Raises:
        KeyError, TypeError, ValueError: the form is not that of such a value.
        WorkbenchError: the value itself refuses its content, or a file is not to be had.
    """
    if isinstance(kind, type) and kind in PLAIN:
        # A whole number in a float's place stays one: otherwise the digest would differ.
        return form
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if kind is Message:
        return message_of(form)
    if kind is pin.SE3:
        return pin.SE3(np.array(form, dtype=np.float64))
    if np.ndarray in (kind, origin):
        return _restored_array(form, read)
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        recorded, form = form, _newer(form) if kind is Controller else form
        fields = _fields_of(kind)
        if fields.renamed:
            form = {fields.renamed.get(name, name): value for name, value in form.items()}
        # A field that has come since has its default.
        if not fields.needed <= set(form) - fields.made <= fields.names:
            raise ValueError(f"fields {sorted(form)} where {sorted(fields.names)} were expected")
        known = fields.names & set(form)
        value = kind(
            **{name: restore_value(fields.hints[name], form[name], read) for name in known}
        )
        if "digest" in fields.made and not fields.digested <= known:
            # What an older version wrote keeps the digest under which it is on record.
            object.__setattr__(value, "digest", digest_of(recorded))
        return value
    if isinstance(kind, type) and issubclass(kind, (enum.Enum, Strategy)):
        return kind(form)
    if origin is types.UnionType or origin is typing.Union:
        present = [argument for argument in arguments if argument is not type(None)]
        if Message in present and set(present) <= {Message, str}:
            # Once every remark was a text, and that was none.
            if isinstance(form, str) and str in present:
                return form
            is_none = form is None or (form == "" and type(None) in arguments)
            return None if is_none else message_of(form)
        if set(present) <= PLAIN:
            return form
        if form is None and len(present) < len(arguments):
            return None
        return restore_value(
            present[0] if len(present) == 1 else _kind_of(present, form), form, read
        )
    if origin is frozenset:
        return frozenset(restore_value(arguments[0], item, read) for item in form)
    if origin is tuple:
        kinds = [arguments[0]] * len(form) if arguments[1:] == (...,) else arguments
        return tuple(
            restore_value(item_kind, item, read)
            for item_kind, item in zip(kinds, form, strict=True)
        )
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return {key: restore_value(arguments[1], item, read) for key, item in form.items()}
    if origin is typing.Literal:
        return form
    raise TypeError(f"no way back from canonical form to {kind}")


def _newer(form: Any) -> Any:
    """A controller as it is written now: once only the name of its link was."""
    if "protocol" not in form:
        return form
    kept = {name: value for name, value in form.items() if name != "protocol"}
    return {**kept, "motion": canonical(link_named(form["protocol"]).motion)}


def _kind_of(kinds: Sequence[Any], form: Any) -> Any:
    """Which of several dataclasses a form is of: its fields say so, one of them perhaps `kind`."""
    for kind in kinds:
        fields = {field.name: field for field in dataclasses.fields(kind)}
        later = {name for name, field in fields.items() if field.metadata.get("later")}
        if set(fields) - {"digest"} - later <= set(form) <= set(fields) and (
            "kind" not in fields or fields["kind"].default == form["kind"]
        ):
            return kind
    raise ValueError(f"fields {sorted(form)} fit none of the values expected")


def _is_needed(field: "dataclasses.Field[Any]") -> bool:
    has_default = field.default is not MISSING or field.default_factory is not MISSING
    return field.init and not has_default


@dataclasses.dataclass(frozen=True, slots=True)
class _Fields:
    """The fields of a dataclass, as a form is read by them: a long session has very many forms.

    `hints` are their types; `names` are given, `needed` have no default, and `made` the value
    makes itself.  `digested` enter its digest even at their defaults.  `renamed`: first name, by
    which a field is on record (`digest.called`) -> name.
    """

    hints: Mapping[str, Any]
    names: frozenset[str]
    needed: frozenset[str]
    made: frozenset[str]
    digested: frozenset[str]
    renamed: Mapping[str, str]


@functools.cache
def _fields_of(kind: type[Any]) -> _Fields:
    fields = dataclasses.fields(kind)
    given = [field for field in fields if field.init]
    return _Fields(
        typing.get_type_hints(kind),
        frozenset(field.name for field in given),
        frozenset(field.name for field in given if _is_needed(field)),
        frozenset(field.name for field in fields if not field.init),
        frozenset(field.name for field in given if not field.metadata.get("later")),
        {field.metadata["called"]: field.name for field in fields if "called" in field.metadata},
    )


def _restored_array(form: Any, read: ReadFile) -> np.ndarray[Any, Any]:
    if not isinstance(form, Mapping):
        return np.array(form)
    shape = cast(Mapping[str, Any], form)
    return np.frombuffer(read(shape["sha256"]), dtype=shape["type"]).reshape(shape["shape"])


def _collect(value: Any, found: dict[str, memoryview]) -> None:
    match value:
        case np.ndarray():
            if value.size > LARGE:
                block: np.ndarray[Any, Any] = np.ascontiguousarray(value)
                content = block.reshape(-1).view(np.uint8).data
                found[hashlib.sha256(content).hexdigest()] = content
        case Mapping():
            for item in cast(Mapping[Any, Any], value).values():
                _collect(item, found)
        case list() | tuple() | frozenset():
            for item in cast(tuple[Any, ...], value):
                _collect(item, found)
        case _ if dataclasses.is_dataclass(value):
            for field in dataclasses.fields(value):
                _collect(getattr(value, field.name), found)
        case _:
            pass

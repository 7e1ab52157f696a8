"""The keys that a plug-in has of its own in a cell file, and where its errors belong."""

from collections.abc import Generator
from contextlib import contextmanager

from workbench.formats.files.toml_keys import Table
from workbench.model.errors import FileError, InputError
from workbench.plugins.options import Options, options_of


def read_options(table: Table, kind: type) -> Options:
    """The keys of its own that a plug-in has, as a table `options`; see `plugins.options`."""
    given = table.table("options").plain() if table.has("options") else {}
    try:
        options_of(kind, given)
    except InputError as error:
        raise table.error("options", str(error)) from None
    return given


@contextmanager
def refused_at(table: Table, key: str) -> Generator[None]:
    """What a plug-in refuses is reported with the place in the file."""
    try:
        yield
    except FileError:
        raise
    except InputError as error:
        raise table.error(key, str(error)) from None

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mutations import mutated, only_file_errors

from workbench.formats.files.toml_keys import Table, read_toml
from workbench.model.errors import FileError


def table(tmp_path: Path, text: str) -> Table:
    path = tmp_path / "thing.toml"
    path.write_text(text, encoding="utf-8")
    return read_toml(path)


def test_values_of_every_kind_are_read(tmp_path: Path) -> None:
    top = table(
        tmp_path,
        'name = "peg"\non = true\ncount = 3\nsize = 2\nxyz = [1, 2.5, -3]\nwords = ["a", "b"]\n'
        'm = [[1, 2], [3, 4]]\npairs = [["a", "b"]]\n[inner]\nx = 1.5\n[[item]]\nk = 1\n[[item]]\n'
        "k = 2\n",
    )
    assert top.text("name") == "peg"
    assert top.flag("on") is True
    assert top.whole("count", low=0, high=9) == 3
    assert type(top.number("size")) is float
    assert top.numbers("xyz", 3).tolist() == [1.0, 2.5, -3.0]
    assert top.texts("words") == ("a", "b")
    assert top.rows("m", 2).tolist() == [[1, 2], [3, 4]]
    assert top.text_rows("pairs", 2) == [("a", "b")]
    assert top.table("inner").number("x") == 1.5
    assert [item.whole("k", low=0, high=9) for item in top.tables("item")] == [1, 2]
    top.finish()


def test_what_is_not_given_takes_its_default(tmp_path: Path) -> None:
    top = table(tmp_path, "")
    assert top.text("name", "none") == "none"
    assert top.number("size", 2.0) == 2.0
    assert top.numbers("xyz", 3, [0, 0, 0]).tolist() == [0, 0, 0]
    assert list(top.tables("item")) == []
    assert not top.has("name")
    top.finish()


Ask = Callable[[Table], object]
WRONG: dict[str, tuple[str, Ask, str]] = {
    "missing": ("", lambda t: t.number("size"), "key size: is missing; a number is expected"),
    "text for number": ('size = "2"', lambda t: t.number("size"), "a number is expected, '2' is"),
    "flag for number": ("size = true", lambda t: t.number("size"), "a number is expected, True"),
    "flag for whole": ("n = true", lambda t: t.whole("n", low=0, high=2), "a whole number is exp"),
    "number for flag": ("on = 1", lambda t: t.flag("on"), "true or false is expected, 1 is"),
    "fraction": ("n = 1.0", lambda t: t.whole("n", low=0, high=2), "a whole number is expected"),
    "NaN": ("size = nan", lambda t: t.number("size"), "a finite number is expected, nan"),
    "infinite": ("size = -inf", lambda t: t.number("size"), "a finite number is expected, -inf"),
    "beyond floats": (f"size = {10**400}", lambda t: t.number("size"), "a finite number is expe"),
    "huge": (
        "n = 0x" + "f" * 9000,
        lambda t: t.whole("n", low=0, high=2),
        "a number of thousands of digits is not a whole number from 0 to 2",
    ),
    "too small": ("size = 0.5", lambda t: t.number("size", low=1, high=2), "0.5 is not between 1"),
    "too large": ("n = 3", lambda t: t.whole("n", low=0, high=2), "3 is not a whole number from"),
    "short list": ("xyz = [1, 2]", lambda t: t.numbers("xyz", 3), "3 numbers are expected, 2"),
    "text in list": ('xyz = [1, "2"]', lambda t: t.numbers("xyz", 2), "number is expected, '2'"),
    "number in texts": ('words = ["a", 1]', lambda t: t.texts("words"), "of texts is expected, 1"),
    "flat rows": ("m = [1, 2]", lambda t: t.rows("m", 2), r"key m\[1\]: a list of numbers is"),
    "short row": ("m = [[1, 2], [3]]", lambda t: t.rows("m", 2), r"m\[2\]: 2 numbers are expecte"),
    "not among": (
        'kind = "cone"',
        lambda t: t.text("kind", among=("box",)),
        "'cone' is not one of",
    ),
    "empty text": ('name = ""', lambda t: t.text("name"), "is an empty text"),
    "bell": ('name = "a\\u0007"', lambda t: t.text("name"), "cannot be printed"),
    "number for table": ("inner = 1", lambda t: t.table("inner"), "a table is expected, 1 is"),
    "list of numbers for tables": (
        "item = [1]",
        lambda t: list(t.tables("item")),
        "an array of tables is expected, entry 1 is 1",
    ),
    "place": (
        "[[item]]\n[[item]]\n[item.inner]\nx = 'a'",
        lambda t: [i.table("inner").number("x") for i in list(t.tables("item"))[1:]],
        r"thing\.toml: key item\[2\]\.inner\.x: a number is expected",
    ),
    "long value": (
        f"size = '{'a' * 5000}'",
        lambda t: t.number("size"),
        r"a number is expected, 'a{56}\.\.\. is given",
    ),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_a_wrong_value_is_refused_with_its_key(tmp_path: Path, wrong: str) -> None:
    text, ask, message = WRONG[wrong]
    with pytest.raises(FileError, match=message):
        ask(table(tmp_path, text))


def test_an_unknown_key_is_refused_with_the_nearest_known_one(tmp_path: Path) -> None:
    top = table(tmp_path, "radius_m = 1\n")
    top.has("radius_mm")
    top.has("length_mm")
    message = r"key radius_m: is not known here; did you mean 'radius_mm'\? \(known: length_mm, rad"
    with pytest.raises(FileError, match=message):
        top.finish()


UNREADABLE: dict[str, tuple[bytes, str]] = {
    "not TOML": (b"name = peg", r"is not valid TOML: .*line 1"),
    "key twice": (b"a = 1\na = 2", "is not valid TOML"),
    "not text": (b"a = '\xff'", "is not a text file in UTF-8"),
    "too long": (b"#" * (4 * 1024 * 1024 + 1), "is longer than 4 MB"),
    "thousands of digits": (b"a = " + b"9" * 5000, "is not valid TOML"),
    "deep": (b"a = " + b"[" * 100_000, "is nested too deeply"),
}


@pytest.mark.parametrize("unreadable", UNREADABLE)
def test_an_unreadable_file_is_refused(tmp_path: Path, unreadable: str) -> None:
    content, message = UNREADABLE[unreadable]
    (tmp_path / "thing.toml").write_bytes(content)
    with pytest.raises(FileError, match=message):
        read_toml(tmp_path / "thing.toml")


@pytest.mark.parametrize("name", ["none.toml", ".", "a\0b", "x" * 300])
def test_a_name_without_a_file_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(FileError):
        read_toml(tmp_path / name)


def test_a_byte_order_mark_is_passed_over(tmp_path: Path) -> None:
    (tmp_path / "thing.toml").write_bytes(b"\xef\xbb\xbfname = 'peg'\r\n")
    assert read_toml(tmp_path / "thing.toml").text("name") == "peg"


@settings(
    deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_only_file_errors_come_out_of_broken_toml(tmp_path: Path, data: st.DataObject) -> None:
    def read(path: Path) -> None:
        top = read_toml(path)
        top.numbers("xyz", 3, [0, 0, 0])
        for item in top.tables("item"):
            item.text("name")
            item.finish()
        top.finish()

    valid = b"xyz = [1, 2.5, 3]\n[[item]]\nname = 'a'\n[[item]]\nname = \"\\u00e4\"\n"
    only_file_errors(tmp_path / "thing.toml", data.draw(mutated(valid)), read)

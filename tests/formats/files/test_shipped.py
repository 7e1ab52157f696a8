from pathlib import Path

import pytest

from workbench.formats.files.shipped import find
from workbench.model.errors import FileError


def test_a_shipped_part_is_found_by_its_name_from_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert (find("parts", "keyed_cylinder") / "part.toml").is_file()


def test_the_working_directory_wins_over_what_is_shipped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = tmp_path / "parts" / "keyed_cylinder"
    own.mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    assert find("parts", "keyed_cylinder") == own


def test_a_path_that_exists_wins_over_names(tmp_path: Path) -> None:
    assert find("parts", str(tmp_path)) == tmp_path


def test_a_folder_named_like_a_part_does_not_hide_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "keyed_cylinder").mkdir()
    monkeypatch.chdir(tmp_path)
    assert find("parts", "keyed_cylinder") != Path("keyed_cylinder")


@pytest.mark.parametrize(
    "name", ["", ".", "..", "cube", "../parts/none", "/none", "a\0b", "x" * 5000, "\ud800"]
)
def test_an_unknown_name_is_refused_with_those_that_are_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileError, match=r"under parts/ \(there is .*keyed_cylinder") as refusal:
        find("parts", name)
    assert str(refusal.value).isprintable()

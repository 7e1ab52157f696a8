"""Pallets in layers in a cell file: places above places, and every mistake named."""

import shutil

import numpy as np
import pytest

from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.writer import write_cell
from workbench.formats.files.shipped import find
from workbench.model.errors import FileError

PALLET = """[[arm.place]]
part_position_mm = [420, -330, 130]
part_rpy_deg = [180, 0, 90]
grid = [3, 2, 4]
pitch_mm = [60, 80, 25]
"""


@pytest.fixture
def with_pallet(tmp_path):
    """A copy of the YuMi's cell whose right arm has other places."""

    def made(text: str, keeps: str = "keeps_parts = true\n"):
        shutil.copytree(find("robots", "yumi"), tmp_path / "yumi", dirs_exist_ok=True)
        path = tmp_path / "yumi" / "cell.toml"
        whole = (find("robots", "yumi") / "cell.toml").read_text(encoding="utf-8")
        head, _, rest = whole.partition("[[arm.place]]")
        rest = rest[rest.index("[[arm]]") :]
        path.write_text(f"{head.rstrip()}\n{keeps}\n{text}\n{rest}", encoding="utf-8")
        return path

    return made


def test_layers_lie_above_each_other_the_lowest_first(with_pallet):
    right, left = read_cell(with_pallet(PALLET)).arms
    assert left.part_places == () and len(right.part_places) == 24
    assert [place.layer for place in right.part_places] == sorted([1, 2, 3, 4] * 6)
    assert {place.pallet for place in right.part_places} == {1}
    at = np.array([place.T_world_part.translation for place in right.part_places]) * 1000
    # Turned about x by 180 and about z by 90 degrees its x is the world's y, its y the world's x.
    np.testing.assert_allclose(at[:4], [[420, -330, 130], [420, -270, 130], [420, -210, 130],
                                        [500, -330, 130]], atol=1e-6)  # fmt: skip
    np.testing.assert_allclose(at[6::6] - at[0], np.outer([1, 2, 3], [0, 0, 25]), atol=1e-6)


def test_two_pallets_are_told_apart_and_other_places_are_of_none(with_pallet):
    single = "[[arm.place]]\npart_position_mm = [330, -330, 130]\n"
    text = PALLET.replace("[3, 2, 4]", "[1, 1, 2]").replace("[60, 80, 25]", "[0, 0, 25]")
    arm = read_cell(with_pallet(text + single + text.replace("420", "500"))).arms[0]
    assert [(one.pallet, one.layer) for one in arm.part_places] == [
        (1, 1), (1, 2), (0, 1), (2, 1), (2, 2)
    ]  # fmt: skip


def test_one_layer_is_as_if_none_was_said(with_pallet):
    flat = read_cell(with_pallet(PALLET.replace("2, 4]", "2]").replace("80, 25]", "80]")))
    one = read_cell(with_pallet(PALLET.replace("2, 4]", "2, 1]").replace("80, 25]", "80, 0]")))
    assert flat.digest == one.digest
    assert {place.pallet for place in one.arms[0].part_places} == {0}


@pytest.mark.parametrize("grid", ["[3, 2, 4]", "[3, 1, 2]", "[1, 4, 3]", "[1, 1, 5]"])
def test_a_written_cell_has_the_same_pallets(with_pallet, tmp_path, grid):
    text = PALLET.replace("[3, 2, 4]", grid) + "\n[[arm.place]]\npart_position_mm = [1, 2, 3]\n"
    cell = read_cell(with_pallet(text))
    again = read_cell(write_cell(tmp_path / "again", cell, {}))
    for one, other in zip(cell.arms[0].part_places, again.arms[0].part_places, strict=True):
        assert one.T_world_part.isApprox(other.T_world_part, 1e-6)
        assert (one.pallet, one.layer) == (other.pallet, other.layer)


def test_a_pallet_that_was_moved_on_the_page_is_changed_in_the_file(with_pallet):
    path = with_pallet(PALLET)
    cell = read_cell(path)
    save_cell(path, cell)  # nothing to be written
    assert read_cell(path).digest == cell.digest


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("2, 4]", "2, 0]", "grid: 0 is not between 1 and 100"),
        ("2, 4]", "2, 1000]", "grid: 1000 is not between 1 and 100"),
        ("2, 4]", "2, 2.5]", "grid: 2.5 is not a whole number"),
        ("2, 4]", "2, 80]", "grid: 480 places, 400 are allowed"),
        ("2, 4]", "2, 4, 1]", "grid: 2 or 3 numbers are expected, 4 are given"),
        ("80, 25]", "80]", "pitch_mm: 3 numbers are expected, as many as grid has; 2 are"),
        ("2, 4]", "2]", "pitch_mm: 2 numbers are expected, as many as grid has; 3 are"),
        ("80, 25]", "80, 0]", "the third number is how far each layer is above the one below: 0 "),
        ("80, 25]", "80, -25]", "above the one below: -25 is not above 0"),
        ("part_position", "position", "grid: has layers, and the place is a pose of the tool: "),
        ("[180, 0, 90]", "[90, 0, 0]",
         "part_rpy_deg: turns z of the part 90.0 degrees off the vertical; layers need it up or"),
    ],
)  # fmt: skip
def test_mistakes_are_told_in_one_sentence(with_pallet, old, new, says):
    text = PALLET.replace("part_rpy", "rpy") if new == "position" else PALLET
    assert old in text
    with pytest.raises(FileError) as caught:
        read_cell(with_pallet(text.replace(old, new, 1)))
    assert says in str(caught.value) and "\n" not in str(caught.value)


def test_parts_beneath_have_to_stay(with_pallet):
    with pytest.raises(FileError, match="keeps_parts: must be true where places have layers: what"):
        read_cell(with_pallet(PALLET, keeps=""))

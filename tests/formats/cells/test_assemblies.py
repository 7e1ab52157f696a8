"""What a cell file says of parts that come onto others: read, written, and every mistake named."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.writer import write_cell
from workbench.formats.files.shipped import find
from workbench.model.derived.assembling import assembled_kinds, insertion_of
from workbench.model.derived.by_recipe import wanted_parts, with_recipe
from workbench.model.digest import canonical
from workbench.model.errors import FileError
from workbench.model.recipes.joint import Joint
from workbench.model.recipes.kit import Insertion, Wanted

SPACER = '[[recipe.item]]\npart = "spacer"\non = "bolt"\n'
INSERT = "position_mm = [0, 0, 0]\ninsert_mm = 60\nclearance_mm = 0.5\n"


@pytest.fixture
def changed(tmp_path):
    """A copy of the cell that assembles, by its first recipe, with a text changed; its path."""

    def made(was: str = "", becomes: str = "", add: str = "") -> Path:
        shutil.copytree(find("robots", "yumi"), tmp_path / "robots" / "yumi", dirs_exist_ok=True)
        shutil.copytree(find("parts", "bolt").parent, tmp_path / "parts", dirs_exist_ok=True)
        path = tmp_path / "robots" / "yumi" / "assembly.toml"
        text, _ = path.read_text(encoding="utf-8").split("[[recipe]]\nnumber = 2")
        assert was in text
        path.write_text(text.replace(was, becomes, 1) + add, encoding="utf-8")
        return path

    return made


def test_a_recipe_says_how_a_part_comes_onto_another_one(changed, tmp_path):
    cell = read_cell(changed())
    down = (0.0, 0.0, -1.0)
    joint = Joint((0.0, 0.0, 0.035), 0.059, 0.02, 0.059, 0.001, 0.002, 0.001)
    said = Insertion("bolt", (0.0, 0.0, -0.014), (0.0, 0.0, 0.0), down, 0.065, 0.0005, joint)
    chosen = with_recipe(cell, 1)
    assert (insertion_of(chosen, "spacer"), insertion_of(chosen, "bolt")) == (said, None)
    assert assembled_kinds(chosen) == {"bolt", "spacer"} and assembled_kinds(cell) == set()
    assert wanted_parts(chosen) == Wanted({"bolt": 1, "spacer": 1}, in_order=True)
    assert read_cell(write_cell(tmp_path / "written", cell, {})).recipes == cell.recipes


def test_a_recipe_states_that_a_base_is_looked_at_again(changed, tmp_path):
    cell = read_cell(changed("insert_mm = 65", "insert_mm = 65\nlook_again = true"))
    found = insertion_of(with_recipe(cell, 1), "spacer")
    assert found is not None and found.look_again
    assert read_cell(write_cell(tmp_path / "written", cell, {})).recipes == cell.recipes
    # Cells without the key have the digests that they had.
    believed = insertion_of(with_recipe(read_cell(changed()), 1), "spacer")
    assert "look_again" not in canonical(believed)


def test_a_recipe_need_not_say_what_a_joint_tolerates(changed):
    path = changed()
    text = path.read_text(encoding="utf-8")
    path.write_text(text[: text.index("[recipe.item.joint]")], encoding="utf-8")
    found = insertion_of(with_recipe(read_cell(path), 1), "spacer")
    assert found is not None and found.joint is None


def test_a_place_says_what_its_nest_leaves(changed, tmp_path):
    cell = read_cell(
        changed("tolerance_deg = 3", "tolerance_deg = 3\ncentred_mm = 0.2\ncentred_deg = 0.5")
    )
    right, left = (arm.part_places[0].centred for arm in cell.arms)
    assert right == pytest.approx((0.0002, np.deg2rad(0.5))) and left is None
    again = read_cell(write_cell(tmp_path / "written", cell, {}))
    assert again.arms[0].part_places[0].centred == pytest.approx(right)


def test_a_direction_of_any_length_will_do_and_down_is_meant_where_there_is_none(changed):
    long = read_cell(changed("insert_along = [0, 0, -1]", "insert_along = [0, 0, -20]"))
    none = read_cell(changed("insert_along = [0, 0, -1]\n", ""))
    assert long.recipes == none.recipes


@pytest.mark.parametrize(
    ("was", "becomes", "add", "says"),
    [
        ('on = "bolt"', 'on = "nut"', "", "spacer is on nut, and no earlier item of the recipe is"),
        ('on = "bolt"', 'on = "spacer"', "", "spacer is on spacer, which is itself on spacer"),
        ('part = "bolt"\n\n', f'part = "bolt"\non = "spacer"\n{INSERT}', "",
         "bolt is on spacer, which is itself on bolt"),
        ('[[recipe.item]]\npart = "bolt"', "", '\n[[recipe.item]]\npart = "bolt"\n',
         "spacer is on bolt, and no earlier item"),
        ('part = "bolt"\n\n', 'part = "bolt"\ncount = 2\n\n', "", "the recipe has 2 bolt"),
        ('on = "bolt"', 'on = "bolt"\ncount = 3', "", "the recipe has 3 spacer"),
        ("insert_along = [0, 0, -1]", "insert_along = [0, 0, 0]", "", "insert_along.*no length"),
        ("insert_along = [0, 0, -1]", "insert_along = [0, 0, 1]", "",
         "insert_along brings spacer to bolt from below"),
        ("insert_along = [0, 0, -1]", "insert_along = [1, 0, 0.1]", "", "from below"),
        ("insert_along = [0, 0, -1]", "insert_along = [1, 0]", "", "3 numbers are expected"),
        ("clearance_mm = 0.5", "clearance_mm = -0.5", "", "clearance_mm.*-0.5 .*0.05"),
        ("clearance_mm = 0.5", "clearance_mm = 0", "", "clearance_mm"),
        ("clearance_mm = 0.5\n", "", "", "clearance_mm.*missing"),
        ('part = "bolt"\n\n', 'part = "bolt"\nlook_again = true\n\n', "",
         "look_again.*`on` is expected"),
        ("insert_mm = 65", 'insert_mm = 65\nlook_again = "yes"', "", "look_again"),
        ("insert_mm = 65", "insert_mm = 0", "", "insert_mm.*0 .*1 .*500"),
        ("insert_mm = 65", 'insert_mm = "far"', "", "insert_mm.*a number"),
        ("position_mm = [0, 0, -14]\n", "", "", "position_mm.*missing"),
        ('on = "bolt"\n', "", "", "position_mm"),
        ('acceleration_deg = 600', "acceleration_deg = 600\npasses_parts_on = true", "",
         "the right arm passes parts on"),
        ("radial_clearance_mm = 1", "radial_clearance_mm = 0", "",
         "radial_clearance_mm.*0 .*0.001 .*20"),
        ("radial_clearance_mm = 1", "radial_clearance_mm = -1", "", "radial_clearance_mm.*-1 "),
        ("radial_clearance_mm = 1\n", "", "", "radial_clearance_mm.*missing"),
        ("mouth_mm = [0, 0, 35]\n", "", "", "mouth_mm.*missing"),
        ("mouth_mm = [0, 0, 35]", "mouth_mm = [0, 0, 95]", "",
         "mouth_mm lies 60.0 mm outside of bolt"),
        ("chamfer_mm = 2", "chamfer_mm = 20", "",
         "chamfer_mm 20.0 mm is not smaller than spacer, which reaches 17.3 mm sideways"),
        ("chamfer_mm = 2", "chamfer_mm = -2", "", "chamfer_mm"),
        ("compliance_mm = 1", "compliance_mm = -1", "", "compliance_mm"),
        ("compliance_mm = 1", "compliance_mm = 1\nshare = 0", "", "share.*0 .*0.01 .*0.999"),
        ("compliance_mm = 1", "compliance_mm = 1\nshare = 1.1", "", "share.*1.1"),
        ("compliance_mm = 1", "compliance_mm = 1\nfloat_mm = 1", "", "float_mm"),
        ("depth_mm = 59", "depth_mm = 66", "", "depth_mm.*66 is more than insert_mm, 65"),
        ("part_length_mm = 20", "part_length_mm = 20\nbase_length_mm = 20", "",
         "depth_mm.*59 brings the part past its base"),
        ('part = "bolt"\n\n', 'part = "bolt"\n\n[recipe.item.joint]\nmouth_mm = [0, 0, 0]\n', "",
         "joint.*`on` is expected"),
        ("tolerance_deg = 3", "tolerance_deg = 3\ncentred_mm = 0.2", "", "centred_deg.*missing"),
        ("tolerance_deg = 3", "tolerance_deg = 3\ncentred_mm = -1\ncentred_deg = 1", "",
         "centred_mm.*-1 "),
    ],
)  # fmt: skip
def test_what_cannot_be_assembled_is_refused_in_one_sentence(changed, was, becomes, add, says):
    with pytest.raises(FileError) as caught:
        read_cell(changed(was, becomes, add))
    message = str(caught.value)
    assert re.search(says, message), message
    assert "\n" not in message


def test_a_base_under_another_part_cannot_be_looked_at_again(changed):
    three = ('"../../parts/spacer"]', '"../../parts/spacer", "../../parts/puck"]')
    puck = f'\n[[recipe.item]]\npart = "puck"\non = "bolt"\n{INSERT}'
    assert len(read_cell(changed(*three, puck)).recipes[0].items) == 3
    with pytest.raises(FileError) as caught:
        read_cell(changed(*three, f"{puck}look_again = true\n"))
    assert "look_again of puck needs a bare bolt, and spacer is on it by then" in str(caught.value)


def test_a_base_needs_a_place_that_says_how_it_stands(changed):
    path = changed()
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace('part = "bolt"\npart_pos', 'part = "spacer"\npart_pos'), "utf-8")
    with pytest.raises(FileError, match="no arm has a place with part_position_mm for bolt"):
        read_cell(path)


def test_what_stands_on_a_part_that_lies_may_come_from_the_side(changed):
    """Whether an insertion comes from below depends on how the base lies in the world."""
    path = changed("insert_along = [0, 0, -1]", "insert_along = [0, 0, 1]")
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("part_rpy_deg = [0, 0, 0]", "part_rpy_deg = [180, 0, 0]"), "utf-8")
    assert read_cell(path).recipes[0].items[1].insertion is not None

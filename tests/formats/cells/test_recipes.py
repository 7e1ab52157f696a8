"""Recipes of a cell file: read, applied, written, and every mistake named."""

import shutil
from dataclasses import replace

import pytest

from workbench.formats.cells.differences import difference
from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.writer import write_cell
from workbench.formats.files.shipped import find
from workbench.gui.shared.movable_frames import with_places
from workbench.model.derived.by_recipe import kit_of, strategy_of, wanted_parts, with_recipe
from workbench.model.digest import canonical
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.recipes.kit import KitItem, Wanted
from workbench.model.recipes.recipe import MOST_RECIPES, Recipe

FIRST = "[[arm.place]]\nposition_mm = [330, "

FAST = '[[recipe]]\nnumber = 1\nname = "fast"\nspeed = 0.8\n'

LEFT = """[[recipe]]
number = 7
name = "left trays"
parts = ["keyed_cylinder"]
grasps = ["side"]
places = ["tray"]
strategy = "left"
threshold_mm = 50
"""


@pytest.fixture
def with_recipes(tmp_path):
    """A copy of the YuMi's cell with a part more, a named place for each arm, and these recipes."""

    def made(*texts: str):
        shutil.copytree(find("robots", "yumi"), tmp_path / "yumi", dirs_exist_ok=True)
        path = tmp_path / "yumi" / "cell.toml"
        whole = (find("robots", "yumi") / "cell.toml").read_text(encoding="utf-8")
        whole = whole.replace('parts = ["keyed_cylinder"]', 'parts = ["keyed_cylinder", "bracket"]')
        for side in ("-330", "330"):
            place = f"{FIRST}{side}, 110]\nrpy_deg = [180, 0, 0]"
            assert place in whole
            whole = whole.replace(place, place.replace("]]\n", ']]\nname = "tray"\n'), 1)
        path.write_text("\n".join([whole, *texts]), encoding="utf-8")
        return path

    return made


def test_a_cell_by_a_recipe_has_its_parts_grasps_places_speed_and_threshold(with_recipes):
    cell = read_cell(with_recipes(FAST, LEFT))
    assert [(one.number, one.name) for one in cell.recipes] == [(1, "fast"), (7, "left trays")]
    fast, left = with_recipe(cell, 1), with_recipe(cell, 7)
    assert (fast.policy.speed, fast.policy.threshold) == (0.8, cell.policy.threshold)
    assert [part.name for part in fast.parts] == ["keyed_cylinder", "bracket"]
    assert [part.name for part in left.parts] == ["keyed_cylinder"]
    assert (left.policy.threshold, left.policy.speed) == (0.05, cell.policy.speed)
    assert [len(arm.Ts_world_place) for arm in left.arms] == [1, 1]
    assert all(
        mine.Ts_world_place[0].isApprox(arm.Ts_world_place[0])
        for mine, arm in zip(left.arms, cell.arms, strict=True)
    )
    assert (strategy_of(cell), strategy_of(fast), strategy_of(left)) == ("auto", "auto", "left")
    assert len({cell.digest, fast.digest, left.digest}) == 3
    assert "left trays" in str(difference(cell, left))
    assert with_recipe(cell, 0) is cell


def test_grasps_that_a_recipe_does_not_name_are_disabled(with_recipes):
    cell = read_cell(with_recipes())
    bracket = cell.part("bracket")
    first, *others = [entry.name for entry in bracket.library.entries]
    assert others
    recipe = Recipe(1, "one", ("bracket",), (first,))
    (part,) = with_recipe(replace(cell, recipes=(recipe,)), 1).parts
    assert [entry.name for entry in part.library.entries] == [first, *others]
    enabled = {part.library.entry_of(g.name).name for g in part.grasps if g.is_enabled}
    assert enabled == {first}


def test_a_cell_without_recipes_has_the_digest_that_it_had_before_there_were_any(with_recipes):
    cell = read_cell("yumi")
    assert (cell.recipes, cell.recipe) == ((), 0)
    assert all(arm.place_names == () for arm in cell.arms)
    assert replace(cell, recipes=(Recipe(1, "one"),)).digest != cell.digest


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (FAST + FAST.replace("fast", "slow"), r"recipe.number.*'1' is there 2 times"),
        (FAST + FAST.replace("= 1", "= 2"), r"recipe.name.*'fast' is there 2 times"),
        (FAST.replace("= 1", "= 0"), r"recipe\[1\].number"),
        (FAST + 'parts = ["cap"]\n', r"recipe 1 fast: part cap is not one of .*bracket"),
        (FAST + "parts = []\n", r"recipe\[1\].parts.*names nothing"),
        (FAST + 'grasps = ["top", "side"]\n', r"recipe 1 fast: grasp top is not one of"),
        (FAST + 'grasps = ["side"]\n', r"part bracket has no enabled grasp"),
        (FAST + 'places = ["shelf"]\n', r"place shelf is not one of the named places: tray"),
        (FAST + 'strategy = "third"\n', r"recipe.strategy.*strategy third is not one of auto"),
        (FAST + 'colour = "red"\n', r"recipe\[1\].colour"),
        (FAST + "default = true\n" + FAST.replace("= 1", "= 2") + "default = true\n",
         r"recipe\[1\].default: is not known here"),
        ("".join(FAST.replace("= 1", f"= {k + 1}").replace("fast", f"fast {k}")
                 for k in range(MOST_RECIPES + 1)), r"101 recipes, 100 are allowed"),
    ],
)  # fmt: skip
def test_what_a_recipe_cannot_say_is_refused_by_name(with_recipes, text, problem):
    with pytest.raises(FileError, match=problem):
        read_cell(with_recipes(text))


def test_a_recipe_that_leaves_an_arm_without_a_place_is_refused(with_recipes):
    path = with_recipes(LEFT)
    first, second = path.read_text(encoding="utf-8").split('name = "tray"\n', 1)
    path.write_text(first + second, encoding="utf-8")
    with pytest.raises(FileError, match="recipe 7 left trays: the right arm has no place among"):
        read_cell(path)


def test_an_unknown_number_is_refused_with_those_that_there_are(with_recipes):
    cell = read_cell(with_recipes(FAST, LEFT))
    with pytest.raises(InputError, match="no recipe 3; it has 1 fast, 7 left trays"):
        with_recipe(cell, 3)
    with pytest.raises(InputError, match="has no recipes"):
        with_recipe(read_cell("yumi"), 3)


def test_recipes_and_names_of_places_are_written_and_read_again(with_recipes, tmp_path):
    cell = read_cell(with_recipes(FAST, LEFT))
    again = read_cell(write_cell(tmp_path / "written", cell, {}))
    assert again.recipes == cell.recipes
    assert [arm.place_names for arm in again.arms] == [arm.place_names for arm in cell.arms]


def test_places_that_are_saved_keep_their_names(with_recipes):
    path = with_recipes(LEFT)
    cell = read_cell(path)
    right, left = cell.arms
    more = (*right.Ts_world_place, pose_from_rpy((0.3, -0.3, 0.12)))
    right = with_places(cell, "right", more).arms[0]
    save_cell(path, replace(cell, arms=(right, left)))
    again = read_cell(path)
    assert again.arms[0].place_names == ("tray", "", "", "", "")
    assert again.recipes == cell.recipes


KIT = """[[recipe]]
number = 3
name = "kit"
in_order = true

[[recipe.item]]
part = "bracket"

[[recipe.item]]
part = "keyed_cylinder"
count = 2
"""


def test_a_recipe_says_what_a_kit_consists_of(with_recipes, tmp_path):
    cell = read_cell(with_recipes(FAST, KIT))
    items = (KitItem("bracket", 1), KitItem("keyed_cylinder", 2))
    assert kit_of(cell) == kit_of(with_recipe(cell, 1)) == ()
    assert kit_of(with_recipe(cell, 3)) == items
    assert wanted_parts(cell) is None
    counts = {"bracket": 1, "keyed_cylinder": 1}
    assert wanted_parts(with_recipe(cell, 3), counts) == Wanted({"keyed_cylinder": 1}, True)
    again = read_cell(write_cell(tmp_path / "written", cell, {}))
    assert again.recipes == cell.recipes


@pytest.mark.parametrize(
    ("was", "becomes", "says"),
    [
        ('part = "bracket"', 'part = "nut"', "part nut of the kit is not one of the recipe's"),
        ("in_order", 'parts = ["bracket"]\nin_order', "keyed_cylinder of the kit is not one"),
        ('part = "keyed_cylinder"', 'part = "bracket"', "'bracket' is there 2 times"),
        ("count = 2", "count = 0", "0 is not a whole number from 1 to 99"),
        ("count = 2", "count = 1.5", "a whole number"),
        ("count = 2", "many = 2", "many"),
        ("in_order = true", "in_order = 1", "true or false"),
        (KIT[KIT.index("[[recipe.item]]") :], "", "says nothing without"),
    ],
)
def test_a_kit_that_cannot_be_is_refused_with_its_key(with_recipes, was, becomes, says):
    with pytest.raises(FileError, match=says):
        read_cell(with_recipes(KIT.replace(was, becomes)))


def test_the_digest_of_a_cell_without_kits_is_as_ever():
    cell = read_cell("yumi")
    plain = replace(cell, recipes=(Recipe(1, "fast", speed=0.8),))
    assert "items" not in str(canonical(plain.recipes[0]))
    assert "items" in str(canonical(Recipe(1, "kit", items=(KitItem("bolt", 1),))))

"""What another package adds works in a cell: named in its file, with keys of its own."""

from pathlib import Path

import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import cell_path, read_cell
from workbench.formats.cells.writer import write_cell
from workbench.model.errors import FileError
from workbench.perception.simulation.piles import drop_parts
from workbench.plugins.found import plugins


def cell_file(folder: Path, *changes: tuple[str, str]) -> Path:
    """The yumi cell in a folder of its own, with other words in its file."""
    shipped = cell_path("yumi")
    folder.mkdir(exist_ok=True)
    for other in shipped.parent.iterdir():
        if other.name != "cell.toml" and not (folder / other.name).exists():
            (folder / other.name).symlink_to(other)
    text = shipped.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    (folder / "cell.toml").write_text(text)
    return folder / "cell.toml"


LINK = (
    'protocol = "abb-socket/2"',
    'protocol = "acme-json"\noptions = { tries = 3 }',
)
SCANNER = (
    "[scanner]",
    '[scanner]\nsource = "acme"\naddress = "127.0.0.1:4000"\noptions = { nearest_mm = 200 }',
)
LOCALIZER = (
    "[controller]",
    '[localizer]\nname = "acme-twice"\noptions = { apart_mm = 1 }\n[controller]',
)


def test_all_of_it_is_found(acme):
    ours = {one.name: one for one in plugins() if one.package == "acme-cell"}
    assert set(ours) == {
        "acme",
        "acme-json",
        "acme-vias",
        "acme-twice",
        "acme-pincer",
        "Acme",
    }
    assert all(not one.problem and one.version == "1.0" for one in ours.values())


def test_a_cell_file_names_them_with_their_own_keys(acme, tmp_path):
    cell = read_cell(cell_file(tmp_path / "cell", LINK, SCANNER, LOCALIZER))
    assert cell.scanner.address == "127.0.0.1:4000"
    assert cell.scanner.source == "acme" and cell.scanner.options == {"nearest_mm": 200}
    assert cell.controller.link == "acme-json" and cell.controller.options == {"tries": 3}
    assert cell.localizer.name == "acme-twice"
    assert cell.zone == 0.0, "it stops at each waypoint"
    again = read_cell(write_cell(tmp_path / "written", cell, {}))
    assert again.controller.motion == cell.controller.motion
    assert again.controller.options == cell.controller.options
    assert again.scanner.options == cell.scanner.options
    assert again.localizer == cell.localizer


def test_other_options_make_another_cell_and_none_the_old_one(acme, tmp_path):
    plain = read_cell(cell_file(tmp_path / "plain"))
    assert plain.digest == read_cell("yumi").digest
    one, other = (
        read_cell(cell_file(tmp_path / name, (LOCALIZER[0], LOCALIZER[1].replace("= 1 ", value))))
        for name, value in (("one", "= 1 "), ("other", "= 2 "))
    )
    assert len({plain.digest, one.digest, other.digest}) == 3


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ((LINK[0], LINK[1].replace("3", "0")), "key controller.options: tries: 0 is not between 1"),
        ((LINK[0], LINK[1].replace("tries", "trys")), "controller.options: trys is not known here"),
        ((SCANNER[0], SCANNER[1].replace("200", '"far"')), "options: nearest_mm: a number"),
        ((SCANNER[0], SCANNER[1].replace("200", "[1]")), "nearest_mm: a text, a number or a flag"),
        (
            (LOCALIZER[0], LOCALIZER[1].replace("twice", "once")),
            "localizer.name: 'acme-once' is not",
        ),
    ],
)
def test_wrong_keys_are_refused_with_file_and_key(acme, tmp_path, change, says):
    path = cell_file(tmp_path / "cell", change)
    with pytest.raises(FileError) as error:
        read_cell(path)
    assert says in str(error.value) and str(path) in str(error.value)


def test_a_plan_by_its_planner_for_its_robot_is_proven(acme, tmp_path):
    cell = read_cell(
        cell_file(tmp_path / "cell", LINK, ('planner = "rrtconnect"', 'planner = "acme-vias"'))
    )
    assert cell.policy.planner == "acme-vias"
    parts = drop_parts(cell.parts[:1] * 2, cell.bin, seed=1)
    result = plan_pick(cell, parts, "scan", strategy="alternated", seed=1)
    assert result.proof.holds
    for arm in result.plan.arms:
        for leg in arm.legs:
            assert cell.controller.motion.is_sendable(leg.q), "hundred thousandths of a radian"


def test_a_tool_of_few_numbers_is_mounted(acme, tmp_path):
    text = cell_path("yumi").read_text()
    name = text.split("[[tool]]", 1)[1].split('name = "', 1)[1].split('"', 1)[0]
    kind = '[[tool]]\nname = "pincer"\nkind = "acme-pincer"\noptions = { size = "large" }\n'
    path = cell_file(tmp_path / "cell", ("[[tool]]", f"{kind}[[tool]]"))
    path.write_text(path.read_text().replace(f'tool = "{name}"', 'tool = "pincer"'))
    cell = read_cell(path)
    assert cell.arms[0].tool.name == "pincer" and cell.arms[0].tool.stroke == (0.0, 0.08)

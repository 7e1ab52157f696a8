"""Places of a cell file: poses of the hand and of the part, and every mistake named."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.writer import write_cell
from workbench.formats.files.shipped import find
from workbench.model.digest import digest_of
from workbench.model.errors import FileError
from workbench.model.geometry import pose_from_rpy

FIRST = """[[arm.place]]
position_mm = [330, -330, 110]
rpy_deg = [180, 0, 0]
"""

NEST = """[[arm.place]]
part = "keyed_cylinder"
part_position_mm = [330, -330, 130]     # where it stands
part_rpy_deg = [0, 0, 90]
free_rotation_deg = 15
tolerance_mm = 1.5
tolerance_deg = 4
"""


@pytest.fixture
def with_place(tmp_path):
    """A copy of the YuMi's cell in which the first place reads otherwise."""

    def made(text: str):
        shutil.copytree(find("robots", "yumi"), tmp_path / "yumi", dirs_exist_ok=True)
        path = tmp_path / "yumi" / "cell.toml"
        whole = (find("robots", "yumi") / "cell.toml").read_text(encoding="utf-8")
        assert FIRST in whole
        path.write_text(whole.replace(FIRST, text, 1), encoding="utf-8")
        return path

    return made


def test_a_place_of_a_part_is_read_beside_those_of_the_hand(with_place):
    right, left = read_cell(with_place(NEST)).arms
    assert (len(right.Ts_world_place), len(left.Ts_world_place), left.part_places) == (3, 4, ())
    (place,) = right.part_places
    assert place.T_world_part.isApprox(pose_from_rpy((0.33, -0.33, 0.13), (0, 0, np.pi / 2)), 1e-9)
    told = (place.part, place.free_rotation, place.tolerance, place.turn_tolerance)
    assert told == ("keyed_cylinder", np.deg2rad(15), 0.0015, np.deg2rad(4))
    assert right.places_for("keyed_cylinder") == (place,) and right.places_for("bolt") == ()


def test_what_is_not_said_is_any_part_no_turn_2_mm_and_3_degrees(with_place):
    text = (
        "[[arm.place]]\npart_position_mm = [330, -330, 130]\ngrid = [2, 3]\npitch_mm = [60, 50]\n"
    )
    places = read_cell(with_place(text)).arms[0].part_places
    assert len(places) == 6
    assert np.allclose(places[3].T_world_part.translation, [0.39, -0.28, 0.13])
    for one in places:
        told = (one.part, one.free_rotation, one.tolerance, one.turn_tolerance, one.approach)
        assert told == ("", 0.0, 0.002, np.deg2rad(3), (0.0, 0.0, -1.0))


def test_a_place_says_from_where_its_part_comes_and_keeps_it(with_place, tmp_path):
    path = with_place(NEST + "approach = [0, -3, -4]\n")
    cell = read_cell(path)
    (place,) = cell.arms[0].part_places
    assert np.allclose(place.approach, [0.0, -0.6, -0.8])
    (again,) = read_cell(write_cell(tmp_path / "again", cell, {})).arms[0].part_places
    assert np.allclose(again.approach, place.approach, atol=1e-6)
    other = path.with_name("other.toml")
    other.write_text(path.read_text(encoding="utf-8").replace("[0, -3, -4]", "[0, 0, -7]"))
    plain = path.with_name("plain.toml")
    plain.write_text(path.read_text(encoding="utf-8").replace("approach = [0, -3, -4]\n", ""))
    assert read_cell(other).digest == read_cell(plain).digest != cell.digest


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("part_rpy", "rpy_deg = [0, 0, 0]\npart_rpy",
         "rpy_deg: is the tool's pose, and part_position_mm that of the part: one is expected"),
        ("part_position_mm = [330, -330, 130]", "",
         "part_position_mm: is missing; it is expected beside part_rpy_deg"),
        ('"keyed_cylinder"', '"keyed"',
         "key arm.place.part: 'keyed' is not one of keyed_cylinder"),
        ('"keyed_cylinder"', '""', "part: is an empty text"),
        ("tolerance_mm = 1.5", "tolerance_mm = 0", "tolerance_mm: 0 is not between 1 and 50"),
        ("tolerance_deg = 4", "tolerance_deg = 0", "tolerance_deg: 0 is not between 1 and 45"),
        ("tolerance_deg = 4", "tolerance_deg = nan", "tolerance_deg: a finite number is expected"),
        ("= 15", "= 181", "free_rotation_deg: 181 is not between 0 and 180"),
        ("part_position_mm = [330, -330", "part_position_mm = [330, -33000",
         "part_position_mm: -33000 is not between -20000 and 20000"),
        ("tolerance_mm", "tolerence_mm", "tolerence_mm: is not known here; did you mean"),
        ("tolerance_deg = 4", "approach = [0, 0, 0]",
         "approach: has no length; a direction like [1, 0, 0] is expected"),
        ("tolerance_deg = 4", "approach = [0, 1]", "approach: 3 numbers are expected"),
    ],
)  # fmt: skip
def test_mistakes_are_told_in_one_sentence(with_place, old, new, says):
    assert old in NEST
    with pytest.raises(FileError) as caught:
        read_cell(with_place(NEST.replace(old, new, 1)))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_is_about_parts_is_refused_at_a_place_of_the_hand(with_place):
    with pytest.raises(FileError, match="free_rotation_deg: is about where the part lies; part_"):
        read_cell(with_place(FIRST + "free_rotation_deg = 10\n"))


def test_a_written_cell_has_the_same_places(with_place, tmp_path):
    cell = read_cell(with_place(NEST))
    again = read_cell(write_cell(tmp_path / "again", cell, {}))
    for one, other in zip(cell.arms, again.arms, strict=True):
        assert digest_of(one.part_places) == digest_of(other.part_places)


def test_a_moved_place_changes_one_line_and_its_comment_stays(with_place):
    path = with_place(FIRST + "\n" + NEST)
    before, cell = path.read_text(encoding="utf-8"), read_cell(path)
    right, left = cell.arms
    (nest,) = right.part_places
    T = pose_from_rpy((0.335, -0.33, 0.13), (0, 0, np.pi / 2))
    moved = replace(right, part_places=(replace(nest, T_world_part=T),))
    save_cell(path, replace(cell, arms=(moved, left)))
    after = path.read_text(encoding="utf-8")
    assert after == before.replace("[330, -330, 130]  ", "[335, -330, 130]  ")
    # A taught place of the hand more leaves it where it is.
    taught = replace(moved, Ts_world_place=(*moved.Ts_world_place, pose_from_rpy((0.3, -0.3, 0.2))))
    save_cell(path, replace(cell, arms=(taught, left)))
    again = read_cell(path).arms[0]
    assert len(again.Ts_world_place) == 5
    assert again.part_places[0].T_world_part.isApprox(T, 1e-6)
    assert "# where it stands" in path.read_text(encoding="utf-8")


def test_what_the_page_cannot_change_is_not_written(with_place):
    path = with_place(NEST)
    cell = read_cell(path)
    right, left = cell.arms
    wider = replace(right, part_places=(replace(right.part_places[0], tolerance=0.01),))
    with pytest.raises(FileError, match="cannot be written into the file"):
        save_cell(path, replace(cell, arms=(wider, left)))
    with pytest.raises(FileError, match="cannot be written into the file"):
        save_cell(path, replace(cell, arms=(replace(right, part_places=()), left)))


STATION = """
[[station]]
name = "corner"
fixture = "table"
position_mm = [500, -450, -10]
rpy_deg = [0, 0, 30]
size_mm = [80, 60]
"""


@pytest.fixture
def with_stations(tmp_path):
    """The YuMi's cell with something behind its end."""

    def made(text: str):
        shutil.copytree(find("robots", "yumi"), tmp_path / "yumi", dirs_exist_ok=True)
        path = tmp_path / "yumi" / "cell.toml"
        whole = (find("robots", "yumi") / "cell.toml").read_text(encoding="utf-8")
        path.write_text(whole + text, encoding="utf-8")
        return path

    return made


def test_a_station_is_read_in_the_frame_of_its_fixture_and_goes_along_with_it(with_stations):
    cell = read_cell(with_stations(STATION))
    (station,) = cell.stations
    assert (station.name, station.fixture, station.size.tolist()) == (
        "corner",
        "table",
        [0.08, 0.06],
    )
    T = pose_from_rpy((0.5, -0.45, -0.01), (0, 0, np.deg2rad(30)))
    assert cell.T_world_station(station).isApprox(T, 1e-9)
    shift = pose_from_rpy((0.1, 0.0, 0.02))
    fixtures = tuple(
        replace(one, T_world_fixture=shift * one.T_world_fixture) if one.name == "table" else one
        for one in cell.fixtures
    )
    moved = replace(cell, fixtures=fixtures)
    assert moved.T_world_station(station).isApprox(shift * T, 1e-9)


def test_stations_are_in_the_digest_of_a_cell_that_has_some(with_stations):
    bare, cell = read_cell("yumi"), read_cell(with_stations(STATION))
    assert replace(cell, stations=()).digest == bare.digest != cell.digest


def test_a_written_station_is_read_back(with_stations, tmp_path):
    cell = read_cell(
        with_stations(STATION + STATION.replace("corner", "other").replace("-450", "450"))
    )
    path = write_cell(tmp_path / "written", cell, {})
    text = path.read_text(encoding="utf-8")
    assert text.count("[[station]]") == 2
    parts = find("parts", "keyed_cylinder")
    path.write_text(text.replace('"keyed_cylinder"', f'"{parts}"', 1), encoding="utf-8")
    assert digest_of(read_cell(path).stations) == digest_of(cell.stations)


@pytest.mark.parametrize(
    ("was", "now", "problem"),
    [
        ("size_mm = [80, 60]", "size_mm = [80, 0]", "size_mm: 0 is not between 10 and 5000"),
        ("size_mm = [80, 60]", "", "size_mm"),
        ('fixture = "table"', 'fixture = "shelf"', "'shelf' is no fixture of the cell: table"),
        ("rpy_deg = [0, 0, 30]", "rpy_deg = [0, 1, 30]", "does not lie level"),
        ("rpy_deg = [0, 0, 30]", "rpy_deg = [180, 0, 30]", "does not lie level"),
        ('name = "corner"', 'name = ""', "name"),
        ("size_mm = [80, 60]", "size_mm = [80, 60]\nheight_mm = 3", "height_mm"),
        ("size_mm = [80, 60]", "size_mm = [80, 60]" + STATION, "corner"),
        (
            "size_mm = [80, 60]",
            "size_mm = [80, 60]" + STATION.replace("corner", "beside").replace("500", "560"),
            "corner and beside lie over each other",
        ),
    ],
)
def test_mistakes_about_stations_are_named(with_stations, was, now, problem):
    assert was in STATION
    with pytest.raises(FileError) as error:
        read_cell(with_stations(STATION.replace(was, now, 1)))
    assert problem in str(error.value) and "station" in str(error.value)


def test_stations_beside_each_other_are_two(with_stations):
    other = STATION.replace("corner", "beside").replace("500", "600")
    assert len(read_cell(with_stations(STATION + other)).stations) == 2


def test_a_cell_with_a_station_can_be_edited_and_saved(with_stations):
    path = with_stations(STATION)
    cell = read_cell(path)
    moved = replace(cell, T_world_robot=pose_from_rpy((0.001, 0.0, 0.0)) * cell.T_world_robot)
    save_cell(path, moved)
    assert digest_of(read_cell(path).stations) == digest_of(cell.stations)

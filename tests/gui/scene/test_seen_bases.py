"""A base of an assembly on the page: drawn and described where a scan shows it."""

from dataclasses import replace

import numpy as np
import pytest
from assembling import assembly_cell, placed_bolt

from workbench.app.core.state import State
from workbench.gui.cycle.kit import _kit_words
from workbench.gui.scene.picture import ScenePicture
from workbench.gui.shared.viser_server import close_viser, open_viser
from workbench.model.derived.assembling import rest_pose
from workbench.model.geometry import pose_from_rpy
from workbench.model.recipes.seen_base import SeenBase, SightProblem
from workbench.model.scan import Detection
from workbench.words.words import IN_ENGLISH

CELL = assembly_cell()
PLACED = (Detection("bolt", CELL.arm("right").part_places[0].T_world_part),)
(BOX,) = placed_bolt(CELL)
T_SEEN = rest_pose(CELL, BOX) * pose_from_rpy((0.004, 0.002, 0.0))
SEEN = SeenBase("scan", T_SEEN, np.eye(6) * 1e-8, shift=0.0045, turn=0.01, visible=0.7)
GONE = SeenBase("scan", problem=SightProblem.GONE)


def state_with(seen: SeenBase | None) -> State:
    return State(CELL, placed=PLACED, obstacles=(replace(BOX, seen=seen),))


@pytest.fixture
def scene():
    server = open_viser("127.0.0.1", 0)
    yield ScenePicture(server, CELL, most_points=500)
    close_viser(server)


def place(scene) -> np.ndarray:
    return np.array(scene._scene.get_handle_by_name("/placed/0").position)


def test_a_bolt_is_drawn_where_it_is_seen_as_long_as_that_is_known(scene, view_of):
    views = [view_of(state_with(seen)) for seen in (None, SEEN, GONE)]
    poses = []
    for before, view in zip((None, *views), views, strict=False):
        scene.draw(before, view)
        poses.append(place(scene))
    believed = rest_pose(CELL, BOX).translation
    np.testing.assert_allclose(poses, [believed, T_SEEN.translation, believed], atol=1e-6)


def test_a_line_states_where_the_bolt_was_seen_or_why_not():
    assert "seen" not in _kit_words(state_with(None), IN_ENGLISH)
    assert "olt was seen 4.5 mm and 0.6 deg off its believed pose" in _kit_words(
        state_with(SEEN), IN_ENGLISH
    )
    assert "The scan shows nothing where bolt is believed to stand" in _kit_words(
        state_with(GONE), IN_ENGLISH
    )

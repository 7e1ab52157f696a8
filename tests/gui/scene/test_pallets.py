"""Parts on a pallet in layers as the scene shows them: where they have fallen to, each once."""

import numpy as np
import pytest

from workbench.app.core.state import Phase, State
from workbench.app.picking.pallets import boxes_around
from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.stations import put_down
from workbench.formats.cells.reading import read_cell
from workbench.gui.scene.picture import ScenePicture
from workbench.gui.shared.look import Look
from workbench.gui.shared.playback import timeline
from workbench.gui.shared.viser_server import close_viser, open_viser
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection


@pytest.fixture(scope="module")
def cell():
    return read_cell("robots/tx2_90/pallet.toml")


@pytest.fixture
def scene(cell):
    server = open_viser("127.0.0.1", 0)
    yield ScenePicture(server, cell, most_points=500)
    close_viser(server)


def heights(scene, count):
    """[m] Of the parts drawn beside the bin, None where one is not."""
    found = [scene._scene.get_handle_by_name(f"/placed/{number}") for number in range(count)]
    return [None if one is None else float(one.position[2]) for one in found]


def lying(cell, count):
    places = cell.arms[0].part_places[:count]
    return tuple(Detection("puck", place.T_world_part) for place in places)


def test_parts_lie_on_the_pallet_and_on_each_other(scene, cell, view_of):
    scene.draw(None, view_of(State(cell, placed=lying(cell, 5))))
    np.testing.assert_allclose(heights(scene, 5), [0.135] * 4 + [0.149], atol=3e-4)


def test_the_part_that_was_put_there_just_now_is_seen_once(scene, cell, view_of):
    T = cell.bin.T_world_bin * pose_from_rpy((0.0, 0.0, 0.0075))
    found, before = (Detection("puck", T),), lying(cell, 4)
    plan = plan_pick(cell, found, "scan", obstacles=boxes_around(cell, before)).plan
    placed = (*before, *put_down(cell, plan))
    done = State(cell, phase=Phase.DONE, detections=found, plan=plan, placed=placed)
    shown = view_of(done, Look(time=timeline(plan)[-1].end))
    scene.draw(None, shown)
    *first, last = heights(scene, 5)
    assert None not in first and last is None, "the film shows it where the hand let go of it"
    scene.draw(shown, view_of(State(cell, placed=placed)))
    assert None not in heights(scene, 5)

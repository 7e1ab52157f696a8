"""The point on the surface that keys move: as it is seen, and never off the part."""

from types import SimpleNamespace

import numpy as np
import pytest

from workbench.gui.grasps.surface_keys import FINE_KEY_STEP, KEY_STEP, SurfaceKeys, seen_at
from workbench.gui.grasps.views import POINT_KEYS
from workbench.gui.scene.stage import T_WORLD_STAGE, GraspStage
from workbench.model.part import Part

EYE = np.array([0.0, 0.0, 0.3])
"""Above the part, looking down: right is x, up is y."""


class Ends(list):
    """What became of the point."""

    def take(self, point, normal):
        self.append((point, normal))

    def end(self):
        self.append("ended")


@pytest.fixture
def part(bench) -> Part:
    return bench.state.cell.part("keyed_cylinder")


@pytest.fixture
def ends():
    return Ends()


@pytest.fixture
def keys(visitor, ends):
    camera = SimpleNamespace(
        position=T_WORLD_STAGE.translation + EYE, wxyz=np.array([0.0, 1.0, 0.0, 0.0])
    )
    visitor.client.camera = camera
    return SurfaceKeys(visitor, GraspStage(visitor.client), ends.take, ends.end)


def press(keys, key):
    handle = next(
        handle
        for handle in keys._visitor.gui._gui_input_handle_from_uuid.values()
        if handle._impl.uuid == keys._buttons[key]
    )
    for callback in handle._impl.update_cb:
        callback(SimpleNamespace(client=None, target=handle))


def test_a_ray_meets_the_near_side_with_its_normal_outwards(part):
    point, normal = seen_at(part.mesh, EYE, np.zeros(3))
    assert point[2] == pytest.approx(part.mesh.points[:, 2].max())
    assert normal == pytest.approx([0.0, 0.0, 1.0])
    assert seen_at(part.mesh, EYE, np.array([0.3, 0.0, 0.0])) is None
    assert seen_at(part.mesh, EYE, EYE) is None


@pytest.mark.parametrize(
    ("arrow", "way"),
    [
        ("arrowleft", (-1, 0)),
        ("arrowright", (1, 0)),
        ("arrowup", (0, 1)),
        ("arrowdown", (0, -1)),
    ],
)
def test_arrows_move_the_point_as_it_is_seen_and_shift_moves_it_little(
    keys, part, ends, arrow, way
):
    keys.show(part)
    first = keys._met[0]
    press(keys, arrow)
    np.testing.assert_allclose(keys._met[0] - first, [*(KEY_STEP * np.array(way)), 0.0], atol=1e-6)
    press(keys, f"shift+{arrow}")
    whole = (KEY_STEP + FINE_KEY_STEP) * np.array(way)
    np.testing.assert_allclose(keys._met[0] - first, [*whole, 0.0], atol=1e-6)
    press(keys, "enter")
    np.testing.assert_array_equal(ends[0][0], keys._met[0])


def test_the_point_stays_on_the_part_and_its_edge_is_told(keys, part):
    keys.show(part)
    for _ in range(40):
        press(keys, "arrowright")
    assert "The part ends here" in keys._said.content
    assert np.abs(keys._met[0]).max() < np.abs(part.mesh.points).max() + KEY_STEP


def test_keys_do_nothing_before_and_after_a_point_is_wanted(keys, part, ends):
    for key in POINT_KEYS[:-1]:
        press(keys, key)
    keys.show(part)
    assert 'tabindex="0"' in keys._box.content
    keys.show(None)
    assert keys._box.content == ""
    for key in POINT_KEYS[:-1]:
        press(keys, key)
    assert ends == []
    press(keys, "escape")
    assert ends == ["ended"]

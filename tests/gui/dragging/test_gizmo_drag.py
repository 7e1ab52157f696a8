"""A drag that begins somewhere else than the gizmo stands moves nothing, to its end."""

import asyncio
import time

import msgspec
import numpy as np
import pinocchio as pin
import pytest
from raw_browser import raw_browser
from waiting import wait_until

from workbench.gui.cell.panel import CellPanel
from workbench.gui.dragging.gizmo_drag import GizmoDrag
from workbench.gui.page.server import serve


def at(*p) -> pin.SE3:
    return pin.SE3(np.eye(3), np.array(p, dtype=float))


def test_a_drag_from_where_the_gizmo_stands_may_go_far():
    drag, here = GizmoDrag(), at(0.41, 0, 0)
    assert drag.is_believed("start", here, here)
    assert drag.is_believed("update", here, at(0.41, 0, 0.01))
    assert drag.is_believed("update", here, at(0.41, 0, 0.5))
    assert drag.is_believed("end", here, at(0.41, 0, 0.5))


def test_a_drag_from_the_origin_is_not_believed_and_the_next_one_may_be():
    drag, here = GizmoDrag(), at(0.41, 0, 0)
    assert drag.is_believed("start", here, here)
    assert not drag.is_believed("update", here, at(0, 0, 0.01))
    assert not drag.is_believed("update", here, at(0.41, 0, 0.01))
    assert not drag.is_believed("end", here, at(0, 0, 0.07))
    assert drag.is_believed("start", here, here)
    assert drag.is_believed("update", here, at(0.4, 0, 0))


def test_an_update_that_its_end_has_overtaken_is_not_believed():
    drag, here = GizmoDrag(), at(0.41, 0, 0)
    assert drag.is_believed("start", here, here)
    assert drag.is_believed("end", here, at(0.41, 0, 0.05))
    assert not drag.is_believed("update", here, at(0.41, 0, 0.04))
    assert drag.is_believed("start", here, here)
    assert drag.is_believed("update", here, at(0.41, 0, 0.01))


def message(kind: str, **fields) -> bytes:
    about = {"type": f"TransformControls{kind}Message", "name": "/cell_gizmo", "owner": "0"}
    return msgspec.msgpack.encode(about | fields)


@pytest.mark.parametrize(("lets_go", "height"), [(True, 0.03), (False, 0.0)])
def test_a_thing_stays_where_it_was_when_its_browser_goes_in_the_middle_of_a_drag(
    bench, lets_go, height
):
    page = serve(bench, port=0, most_points=100)
    renderer = page._renderer
    T = bench.state.cell.bin.T_world_bin

    def take_gizmo() -> None:
        wait_until(lambda: renderer._panels)
        (panels,) = renderer._panels.values()
        next(panel for panel in panels if isinstance(panel, CellPanel))._inputs._turn()

    async def drag() -> None:
        p = tuple((T.translation + [0, 0, 0.03]).tolist())
        async with raw_browser(int(page.url.rpartition(":")[2])) as browser:
            await asyncio.to_thread(take_gizmo)
            await browser.send(message("DragStart"))
            await browser.send(message("Update", wxyz=(1.0, 0.0, 0.0, 0.0), position=p))
            await asyncio.to_thread(wait_until, lambda: renderer._look.now.held is not None)
            if lets_go:
                await browser.send(message("DragEnd"))
                await asyncio.to_thread(wait_until, lambda: bench.state.before != ())

    try:
        asyncio.run(drag())
        wait_until(lambda: not renderer._visitors)
        time.sleep(0.3)
        shift = bench.state.cell.bin.T_world_bin.translation - T.translation
        np.testing.assert_allclose(shift, [0, 0, height], atol=1e-6)
        assert renderer._look.now.held is None
    finally:
        page.close()

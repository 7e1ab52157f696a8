"""A plan as one page of HTML that plays it: no server, no network, all in the file."""

import math
from dataclasses import replace

from workbench.app.core.state import State
from workbench.app.runtime.live import Live
from workbench.gui.scene.picture import ScenePicture
from workbench.gui.shared.look import Look, View
from workbench.gui.shared.playback import timeline
from workbench.gui.shared.viser_server import close_viser, open_viser

FRAME = 1 / 15
"""[s] Between two pictures of a recording."""

MOST_POINTS = 20_000
"""Of a scan in a recording."""


def scene_html(state: State) -> bytes:
    """The cell, the scan and the parts of a state, and its plan, played once.

    Args:
        state: with or without a plan.
    """
    server = open_viser("127.0.0.1", 0)
    try:
        runs = timeline(*state.plans)
        # Who stands where does not matter any more: the robot is shown where the plan has it.
        view = View(state, Live(), Look(follows=False), runs, 0.0)
        scene = ScenePicture(server, state.cell, most_points=MOST_POINTS, planned_is_solid=True)
        scene.draw(None, view)
        recording = server.get_scene_serializer()
        for frame in range(1, math.ceil(view.plan_seconds / FRAME) + 1):
            recording.insert_sleep(FRAME)
            # The last picture is that of the end, which need not be a whole number of frames away.
            at = min(frame * FRAME, view.plan_seconds)
            after = replace(view, look=replace(view.look, time=at))
            scene.draw(view, after)
            view = after
        return recording.as_html().encode()
    finally:
        close_viser(server)

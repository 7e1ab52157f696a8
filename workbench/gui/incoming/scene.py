"""What the scene of a page offers: gizmos to drag, things to click on, and the camera."""

# pyright: reportPrivateUsage=false

import math
from collections.abc import Iterable, Sequence
from typing import Any

import viser
from viser import _messages as messages

from workbench.gui.incoming.widgets import NOT_SHOWN, NOT_THERE

FARTHEST_POINT = 1e5
"""[m] Of a place in the scene.  The part that grasps are edited on stands 1 km above the cell."""

FARTHEST_CAMERA = 1e7
"""[m] Of the camera, which people move far away."""

NEAREST = 1e-9
"""[m] Between the camera and what it looks at; also of a direction, without a unit."""

NO_DIRECTION = "no direction"
NO_POSE = "no pose"


def gizmo_problem(message: Any, client: int, *scenes: viser.SceneApi) -> str:
    """Why a gizmo cannot be dragged as a message says; empty when it can."""
    scene = _scene_of(message.owner, scenes)
    if scene is None:
        return NOT_THERE
    # One that was taken away in the middle of its drag still hears of its end.
    gizmo = scene._active_transform_drag_handles.get((client, message.name))  # pyright: ignore
    gizmo = gizmo or scene._handle_from_transform_controls_name.get(message.name)
    if gizmo is None:
        return NOT_THERE
    if not gizmo._impl.removed and not _is_shown(scene, message.name):
        return NOT_SHOWN
    if not isinstance(message, messages.TransformControlsUpdateMessage):
        return ""
    is_pose = _are_within(message.position, FARTHEST_POINT) and is_turn(message.wxyz)
    return "" if is_pose else NO_POSE


def node_problem(message: messages.SceneNodeClickMessage, *scenes: viser.SceneApi) -> str:
    """Why a thing in the scene cannot be clicked on as a message says; empty when it can."""
    scene = _scene_of(message.owner, scenes)
    node = None if scene is None else scene._handle_from_node_name.get(message.name)
    if scene is None or node is None:
        return NOT_THERE
    if not node._impl.click_cb:
        return "nobody listens to clicks on it"
    if not _is_shown(scene, message.name):
        return NOT_SHOWN
    number, count = message.instance_index, _count_of(node)
    if number is not None and not 0 <= number < count:
        return "no such one of them"
    if not _are_within(message.screen_pos, FARTHEST_POINT):
        return "no place on the screen"
    return ray_problem(message.ray_origin, message.ray_direction)


def pointer_problem(message: messages.ScenePointerMessage, *scenes: viser.SceneApi) -> str:
    """Why the scene does not offer a click, or a box that is drawn; empty when it does."""
    kind = message.event_type
    if not any(
        callback.event_type == kind for scene in scenes for callback in scene._scene_pointer_cb
    ):
        return "nobody listens to it"
    places = message.screen_pos
    if len(places) != (1 if kind == "click" else 2):
        return "another number of places on the screen"
    if not all(_are_within(place, FARTHEST_POINT) for place in places):
        return "no place on the screen"
    if kind != "click":
        return ""
    return ray_problem(message.ray_origin, message.ray_direction)


def ray_problem(origin: Sequence[float] | None, direction: Sequence[float] | None) -> str:
    """Why two vectors (3,), the first in [m], are no ray; empty when they are."""
    if origin is None or direction is None:
        return "no ray"
    if not _are_within(origin, FARTHEST_CAMERA):
        return "a ray from too far"
    return "" if _is_about_one(direction) else NO_DIRECTION


def camera_problem(message: messages.ViewerCameraMessage) -> str:
    """Why nobody can look as a message says; empty when somebody can."""
    far_away = (*message.position, *message.look_at)
    if not (_are_within(far_away, FARTHEST_CAMERA) and is_turn(message.wxyz)):
        return NO_POSE
    if math.dist(message.position, message.look_at) < NEAREST or not _is_long(message.up_direction):
        return NO_DIRECTION
    if not 0 < message.fov < math.pi or not 0 < message.near < message.far < math.inf:
        return "no such lens"
    return "" if min(message.image_height, message.image_width) >= 0 else "no such picture"


def is_turn(wxyz: Sequence[float]) -> bool:
    """Whether a quaternion (4,) stands for a turn."""
    return _is_about_one(wxyz)


def _scene_of(owner: str, scenes: Iterable[viser.SceneApi]) -> viser.SceneApi | None:
    return next((scene for scene in scenes if scene._owner_id == owner), None)


def _is_shown(scene: viser.SceneApi, name: str) -> bool:
    """Whether a node, and all that it is below of in this scene, can be seen."""
    parts = name.split("/")
    above = ("/".join(parts[: k + 1]) for k in range(1, len(parts)))
    nodes = (scene._handle_from_node_name.get(node_name) for node_name in above)
    return all(node is None or node._impl.visible for node in nodes)


def _count_of(node: Any) -> int:
    """How many things a node is that are clicked on one by one."""
    positions = getattr(node._impl.props, "batched_positions", ())
    return len(positions)


def _are_within(numbers: Sequence[float], most: float) -> bool:
    return all(abs(number) <= most for number in numbers)  # no number is never within


def _is_about_one(numbers: Sequence[float]) -> bool:
    return 0.5 < _length(numbers) < 2.0


def _is_long(numbers: Sequence[float]) -> bool:
    return _length(numbers) > NEAREST


def _length(numbers: Sequence[float]) -> float:
    return math.hypot(*numbers) if all(map(math.isfinite, numbers)) else math.nan

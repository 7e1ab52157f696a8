"""Whether a part that is let go of over a station comes to stand there: physics is asked."""

import mujoco
import numpy as np
from judge_files import Files, pose_of

STILL, LEAN = 0.004, np.deg2rad(2.0)
"""[m, rad] How far a part may move aside, and be tilted, when it is let go of."""

SHAPES = {"box": "box", "cylinder": "cylinder", "sphere": "sphere"}


def stood_on(files: Files, name: str, kind: str, T_put: np.ndarray) -> np.ndarray | str:
    """Where a part (4, 4) stands in the end on a station, or why it does not stand there.

    Args:
        files: of the cell.
        name: of the station.
        kind: of the part.
        T_put: (4, 4) where the hand lets go of it.
    """
    station = next((one for one in files.cell.get("station", ()) if one["name"] == name), None)
    if station is None:
        return "no such station"
    T = pose_of(station)
    for fixture in files.cell["fixture"]:
        if fixture["name"] == station.get("fixture"):
            T = pose_of(fixture) @ T
    seen = np.linalg.inv(T) @ T_put
    half = np.array(station["size_mm"]) / 2000
    pieces = "".join(geom_of(piece) for piece in files.parts[kind]["piece"])
    w, x, y, z = quaternion(np.eye(3))
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="0.0005"/><worldbody>
        <geom type="box" size="{half[0]} {half[1]} 0.05" pos="0 0 -0.05" quat="{w} {x} {y} {z}"/>
        <body><freejoint/>{pieces}</body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    data.qpos[:3], data.qpos[3:] = seen[:3, 3], quaternion(seen[:3, :3])
    for _ in range(2500):
        mujoco.mj_step(model, data)
    rests = np.eye(4)
    R = np.empty(9)
    mujoco.mju_quat2Mat(R, data.qpos[3:])
    rests[:3, :3], rests[:3, 3] = R.reshape(3, 3), data.qpos[:3]
    lean = np.arccos(np.clip(rests[2, :3] @ seen[2, :3], -1, 1))
    if lean > LEAN or np.linalg.norm((rests - seen)[:2, 3]) > STILL:
        return "the part does not come to rest on the station"
    if not 0 <= seen[2, 3] - rests[2, 3] + 0.0005 <= files.policy("margin_mm") + 0.003:
        return "the part falls too far"
    return T @ rests


def geom_of(piece) -> str:
    T = pose_of(piece)
    size = {
        "box": lambda: np.array(piece["size_mm"]) / 2000,
        "cylinder": lambda: np.array([piece["radius_mm"], piece["length_mm"] / 2]) / 1000,
        "sphere": lambda: np.array([piece["radius_mm"]]) / 1000,
    }[piece["shape"]]()
    at, turn = (" ".join(map(str, one)) for one in (T[:3, 3], quaternion(T[:3, :3])))
    shape = SHAPES[piece["shape"]]
    return f'<geom type="{shape}" size="{" ".join(map(str, size))}" pos="{at}" quat="{turn}"/>'


def quaternion(R: np.ndarray) -> np.ndarray:
    found = np.empty(4)
    mujoco.mju_mat2Quat(found, np.ascontiguousarray(R).ravel())
    return found

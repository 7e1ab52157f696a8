"""Whether a part may be put onto a pallet in layers, and stays there: physics is asked."""

import mujoco
import numpy as np
from judge_files import Files, pose_of
from judge_stations import geom_of, quaternion

MOST, LEAN, ASIDE = 0.0035, np.deg2rad(2.0), 0.004
"""[m, rad, m] How much more than the margin a part may fall, and how far it may tilt and slide."""


def stacked(files: Files, scene, arm: str, kind: str, T_lies: np.ndarray, lies) -> str:
    """What is wrong with a part (4, 4) that is let go of at a place of a pallet; empty for nothing.

    Args:
        files: of the cell.
        scene: what is known, also of the pallet.
        arm: that brings it.
        kind: of the part.
        T_lies: (4, 4) where the hand lets go of it.
        lies: whether a part lies as a place asks.
    """
    places = [one for one in files.part_places(arm, kind) if one["pallet"]]
    there = [one for one in places if lies(one, T_lies, files.parts[kind])]
    if not there:
        return ""
    place = min(there, key=lambda one: abs(one["T"][2, 3] - T_lies[2, 3]))
    kept = [(box.part, box.T_world_put.homogeneous) for box in scene.obstacles if box.part]
    pallet = [one for one in places if one["pallet"] == place["pallet"]]
    full = [any(lies(one, T, files.parts[name]) for name, T in kept) for one in pallet]
    for one, has_part in zip(pallet, full, strict=True):
        if one is place and has_part:
            return "a part is there"
        if has_part and one["layer"] > place["layer"]:
            return "a part is above"
        if not has_part and one["layer"] == place["layer"] - 1:
            return "the layer beneath is not full"
    return _falls(files, scene, kind, T_lies)


def _falls(files: Files, scene, kind: str, T_lies: np.ndarray) -> str:
    """How a part comes to rest that is let go of among fixtures and what lies there."""
    bodies = ""
    for fixture in files.cell.get("fixture", ()):
        for solid in fixture["solid"]:
            bodies += _body(geom_of(solid), pose_of(fixture) @ pose_of(solid))
    for box in scene.obstacles:
        half = " ".join(map(str, np.asarray(box.size) / 2))
        bodies += _body(f'<geom type="box" size="{half}"/>', box.T_world_box.homogeneous)
    pieces = "".join(map(geom_of, files.parts[kind]["piece"]))
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="0.0005"/><worldbody>{bodies}
        <body><freejoint/>{pieces}</body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    data.qpos[:3], data.qpos[3:] = T_lies[:3, 3], quaternion(T_lies[:3, :3])
    for _ in range(1500):
        mujoco.mj_step(model, data)
    R = np.empty(9)
    mujoco.mju_quat2Mat(R, data.qpos[3:])
    lean = np.arccos(np.clip(R.reshape(3, 3)[2] @ T_lies[2, :3], -1, 1))
    fallen = T_lies[:3, 3] - data.qpos[:3]
    if lean > LEAN or np.linalg.norm(fallen[:2]) > ASIDE:
        return "the part does not stay on the pallet"
    if fallen[2] > files.policy("margin_mm") + MOST:
        return "the part falls too far onto the pallet"
    return ""


def _body(geom: str, T: np.ndarray) -> str:
    at, turn = (" ".join(map(str, one)) for one in (T[:3, 3], quaternion(T[:3, :3])))
    return f'<body pos="{at}" quat="{turn}">{geom}</body>'

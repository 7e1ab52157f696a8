"""Values as messages in JSON with Foxglove's schemas, and plans and verdicts with schemas of ours.

Units are SI and radians, quaternions x, y, z, w.  The schemas are ours to write: what counts are
Foxglove's names of messages and fields.

Source: https://docs.foxglove.dev/docs/sdk/schemas
"""

import base64
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Candidate, Verdict, label_grasp
from workbench.model.plan import Plan, Proof
from workbench.model.scan import Scan

Json = dict[str, Any]

WORLD = "cell_world"
"""The frame of the cell; a robot may have a link of its own that is called `world`."""

INFO, ERROR = 2, 4
"""Levels of a log message."""

FLOAT32 = 7


def _object(title: str = "", optional: tuple[str, ...] = (), **fields: Json) -> Json:
    named = {"title": title} if title else {}
    required = [name for name in fields if name not in optional]
    return {**named, "type": "object", "properties": fields, "required": required}


def _list(items: Json) -> Json:
    return {"type": "array", "items": items}


_TEXT: Json = {"type": "string"}
_NUMBER: Json = {"type": "number"}
_WHOLE: Json = {"type": "integer"}
_YES: Json = {"type": "boolean"}
_NUMBERS = _list(_NUMBER)
_TIME = _object("time", sec=_WHOLE, nsec=_WHOLE)
_VECTOR = _object("foxglove.Vector3", x=_NUMBER, y=_NUMBER, z=_NUMBER)
_TURN = _object("foxglove.Quaternion", x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER)
_POSE = _object("foxglove.Pose", position=_VECTOR, orientation=_TURN)
_FIELD = _object("foxglove.PackedElementField", name=_TEXT, offset=_WHOLE, type=_WHOLE)
_MOVE = _object(
    "foxglove.FrameTransform",
    timestamp=_TIME,
    parent_frame_id=_TEXT,
    child_frame_id=_TEXT,
    translation=_VECTOR,
    rotation=_TURN,
)
_VERDICT: Json = {
    "reason": _TEXT,
    "stage": _TEXT,
    "says": _TEXT,
    "pair": _list(_TEXT),
    "distance": _NUMBER,
    "q": _NUMBERS,
}
_SELDOM = ("pair", "distance", "q")

SCHEMAS: Mapping[str, Json] = {
    schema["title"]: schema
    for schema in (
        _object(
            "foxglove.PointCloud",
            timestamp=_TIME,
            frame_id=_TEXT,
            pose=_POSE,
            point_stride=_WHOLE,
            fields=_list(_FIELD),
            data={"type": "string", "contentEncoding": "base64"},
        ),
        _object("foxglove.FrameTransforms", transforms=_list(_MOVE)),
        _object("foxglove.PosesInFrame", timestamp=_TIME, frame_id=_TEXT, poses=_list(_POSE)),
        _object(
            "foxglove.JointStates",
            timestamp=_TIME,
            joints=_list(_object("foxglove.JointState", name=_TEXT, position=_NUMBER)),
        ),
        _object(
            "foxglove.Log",
            timestamp=_TIME,
            level=_WHOLE,
            message=_TEXT,
            name=_TEXT,
            file=_TEXT,
            line=_WHOLE,
        ),
        _object(
            "workbench.Plan",
            timestamp=_TIME,
            digest=_TEXT,
            strategy=_TEXT,
            guarantee=_TEXT,
            cycle_seconds=_NUMBER,
            arms=_list(
                _object(
                    arm=_TEXT,
                    detection=_WHOLE,
                    part=_TEXT,
                    grasp=_TEXT,
                    joints=_list(_TEXT),
                    legs=_list(
                        _object(
                            name=_TEXT,
                            motion=_TEXT,
                            holding=_YES,
                            opening=_NUMBER,
                            t=_NUMBERS,
                            q=_list(_NUMBERS),
                        )
                    ),
                )
            ),
            sequence=_list(_list(_object(arm=_TEXT, leg=_TEXT))),
            proof=_object(holds=_YES, checks=_WHOLE, clearance=_NUMBER, violations=_list(_TEXT)),
            optional=("proof",),
        ),
        _object(
            "workbench.Verdicts",
            timestamp=_TIME,
            verdict=_object(optional=_SELDOM, **_VERDICT),
            candidates=_list(
                _object(
                    detection=_WHOLE,
                    grasp=_TEXT,
                    arm=_TEXT,
                    rank=_NUMBER,
                    pose=_POSE,
                    optional=_SELDOM,
                    **_VERDICT,
                )
            ),
        ),
    )
}
"""Name -> JSON Schema of every kind of message."""


def nanoseconds(at: float) -> int:
    """A time [s since the epoch] as MCAP counts it."""
    return round(at * 1e9)


def cloud(at: float, scan: Scan) -> Json:
    """A scan as `foxglove.PointCloud`: points [m] in the scanner's frame, and its pose."""
    points = np.ascontiguousarray(scan.points, np.dtype("<f4"))
    fields = [{"name": axis, "offset": 4 * k, "type": FLOAT32} for k, axis in enumerate("xyz")]
    return {
        "timestamp": _time(at),
        "frame_id": WORLD,
        "pose": _pose(scan.T_world_scanner),
        "point_stride": 12,
        "fields": fields,
        "data": base64.b64encode(points.tobytes()).decode(),
    }


def transforms(at: float, poses: Iterable[tuple[str, str, pin.SE3]]) -> Json:
    """Parent, child and `T_parent_child` each, as `foxglove.FrameTransforms`."""
    return {
        "transforms": [
            {
                "timestamp": _time(at),
                "parent_frame_id": parent,
                "child_frame_id": child,
                "translation": _vector(T),
                "rotation": _turn(T),
            }
            for parent, child, T in poses
        ]
    }


def parts(at: float, Ts_world_part: Iterable[pin.SE3]) -> Json:
    """The parts found as `foxglove.PosesInFrame`, in their order."""
    return {"timestamp": _time(at), "frame_id": WORLD, "poses": [_pose(T) for T in Ts_world_part]}


def joints(at: float, values: Mapping[str, float]) -> Json:
    """Joints [rad or m] by name as `foxglove.JointStates`."""
    named = [{"name": name, "position": float(value)} for name, value in values.items()]
    return {"timestamp": _time(at), "joints": named}


def log(at: float, level: int, who: str, says: str, file: str, line: int) -> Json:
    """A line of the record as `foxglove.Log`; `line` is the number of the entry."""
    record = {"level": level, "message": says, "name": who, "file": file, "line": line}
    return {"timestamp": _time(at), **record}


def plan_message(at: float, plan: Plan, proof: Proof | None) -> Json:
    """A plan leg by leg as `workbench.Plan`, with what its proof says."""
    form: Json = {
        "timestamp": _time(at),
        "digest": plan.digest,
        "strategy": str(plan.strategy),
        "guarantee": str(plan.guarantee),
        "cycle_seconds": float(plan.cycle_seconds),
        "arms": [
            {
                "arm": arm.arm,
                "detection": arm.detection,
                "part": plan.detections[arm.detection].part if arm.takes_part else "",
                "grasp": label_grasp(arm.grasp, arm.tcp),
                "joints": list(arm.joints),
                "legs": [
                    {
                        "name": leg.name,
                        "motion": leg.motion,
                        "holding": leg.holding,
                        "opening": leg.opening,
                        "t": leg.t.tolist(),
                        "q": leg.q.tolist(),
                    }
                    for leg in arm.legs
                ],
            }
            for arm in plan.arms
        ],
        "sequence": [
            [{"arm": arm, "leg": leg} for arm, leg in step.runs] for step in plan.sequence
        ],
    }
    if proof is not None:
        form["proof"] = {
            "holds": proof.holds,
            "checks": int(proof.checks),
            "clearance": float(proof.clearance),
            "violations": [str(violation.message) for violation in proof.violations],
        }
    return form


def verdicts(at: float, verdict: Verdict, candidates: Iterable[Candidate]) -> Json:
    """What a planning came to, and every candidate's verdict, as `workbench.Verdicts`."""
    return {
        "timestamp": _time(at),
        "verdict": _verdict(verdict),
        "candidates": [
            {
                "detection": candidate.detection,
                "grasp": candidate.grasp_label,
                "arm": candidate.arm,
                "rank": float(candidate.rank),
                "pose": _pose(candidate.T_world_tcp),
                **_verdict(candidate.verdict),
            }
            for candidate in candidates
        ],
    }


def _verdict(verdict: Verdict) -> Json:
    form: Json = {"reason": str(verdict.reason), "stage": str(verdict.stage), "says": str(verdict)}
    if verdict.pair is not None:
        form["pair"] = list(verdict.pair)
    if verdict.distance is not None:
        form["distance"] = float(verdict.distance)
    if verdict.q is not None:
        form["q"] = verdict.q.tolist()
    return form


def _time(at: float) -> Json:
    seconds, rest = divmod(nanoseconds(at), 10**9)
    return {"sec": seconds, "nsec": rest}


def _vector(T: pin.SE3) -> Json:
    return dict(zip("xyz", T.translation.tolist(), strict=True))


def _turn(T: pin.SE3) -> Json:
    return dict(zip("xyzw", pin.Quaternion(T.rotation).coeffs().tolist(), strict=True))


def _pose(T: pin.SE3) -> Json:
    return {"position": _vector(T), "orientation": _turn(T)}

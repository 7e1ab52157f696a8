"""What the judge asks of a plan beside distances, from `docs/proof.md` and the cell's files."""

from itertools import pairwise

import numpy as np
from judge_files import Files, pose_of, turned
from judge_pallets import stacked
from judge_stations import stood_on
from judge_symmetry import turns, unit
from judge_times import COARSE, FINE, at_rest_between, soonest

LEGS = ("reach", "approach", "extract", "return", "place", "home")
HOLDING = ("extract", "return", "place")
STRAIGHT = ("approach", "extract")

NEAR, SAID = 0.001 + 1e-6, 0.00005 + 1e-6
"""[m] How far any point of a part may be from where it belongs, and from where a plan says that it
is in the hand; and what two libraries differ."""

ASIDE, ASIDE_BETWEEN, TURN = 0.002 + 1e-6, 0.0051, np.deg2rad(1.5) + 1e-4
"""[m, m, rad] How far a straight way may be off at and between waypoints, and what samples miss."""

SOON, SOON_OF_ONE = 0.99, 0.9
"""Of the least time of a leg, and of one way in it: a linear program asks limits at places, and has
marks elsewhere."""

MIDDLE = 0.003
"""[m] By which the middle of a part's solids may be off that of its mesh."""

_known_times: dict[tuple, bool] = {}
"""What a linear program has said: bends leave most legs as they are."""


def rule_broken(files: Files, scene, plan) -> str:
    """The first rule that a plan breaks whatever stands around the robot; empty for none."""
    checks = (_scene(scene, plan), _sequence(files, plan))
    for broken in checks:
        if broken:
            return broken
    for one in plan.arms:
        broken = _legs(files, one) or _grasp(files, plan, one) or _region(files, plan, one)
        if broken:
            return broken
    return ""


def _scene(scene, plan) -> str:
    """What is known to be in the bin, and what the plan says of it."""

    def alike(one, other) -> bool:
        T, other_T = one.T_world_part.homogeneous, other.T_world_part.homogeneous
        return one.part == other.part and np.abs(T - other_T).max() < 1e-6

    def same_box(one, other) -> bool:
        T, other_T = one.T_world_box.homogeneous, other.T_world_box.homogeneous
        return np.abs(one.size - other.size).max() < 1e-6 and np.abs(T - other_T).max() < 1e-6

    if not all(any(alike(a, b) for b in plan.detections) for a in scene.detections):
        return "leaves out a part"
    if not all(any(alike(a, b) for b in scene.detections) for a in plan.detections):
        return "has a part that is not there"
    if not all(any(same_box(a, b) for b in plan.obstacles) for a in scene.obstacles):
        return "leaves out an obstacle"
    kept = [box for box in scene.obstacles if box.part]
    for box in plan.obstacles:
        if box.part and not any(
            box.part == known.part
            and same_box(box, known)
            and np.abs(box.T_world_put.homogeneous - known.T_world_put.homogeneous).max() < 1e-6
            for known in kept
        ):
            return "has a part on a pallet that is not there"
    return ""


def _region(files: Files, plan, one) -> str:
    """Whether the middle of the part taken lies in a region, or over a floor without walls."""
    bin_, found = files.cell["bin"], plan.detections[one.detection]
    length, width, _ = bin_["size_mm"]
    boxes = bin_.get("region", ())
    if not boxes and not bin_.get("walls", True):
        boxes = [{"size_mm": (length, width, 1e6), "position_mm": (0, 0, -5e5)}]
    if not boxes or found.T_world_found is not None:
        return ""
    at = found.T_world_part.homogeneous @ [*_middle(files.parts[found.part]), 1]
    for box in boxes:
        off = np.linalg.inv(pose_of(bin_) @ pose_of(box)) @ at
        half = np.array(box["size_mm"]) / 2000
        if np.all(np.abs(off[:3] - [0, 0, half[2]]) <= half + MIDDLE):
            return ""
    return "takes a part outside of the regions"


def _middle(part) -> np.ndarray:
    """Of the box around a part's solids (3,) [m]."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for piece in part["piece"]:
        T = pose_of(piece)
        radius, length = piece.get("radius_mm", 0), piece.get("length_mm", 0)
        size = piece.get("size_mm", (2 * radius, 2 * radius, length or 2 * radius))
        half = np.abs(T[:3, :3]) @ (np.array(size) / 2000)
        low, high = np.minimum(low, T[:3, 3] - half), np.maximum(high, T[:3, 3] + half)
    return (low + high) / 2


def _sequence(files: Files, plan) -> str:
    names, taken = [one.arm for one in plan.arms], [one.detection for one in plan.arms]
    if not names or len(set(names)) != len(names) or len(set(taken)) != len(taken):
        return "an arm or a part twice, or none"
    runs = [run for step in plan.sequence for run in step.runs]
    for name in names:
        if tuple(leg for arm, leg in runs if arm == name) != LEGS:
            return "legs out of order"
    if len(runs) != 6 * len(names) or any(not 1 <= len(s.runs) <= 2 for s in plan.sequence):
        return "steps of no arm, or of others"
    if any(len({arm for arm, _ in step.runs}) != len(step.runs) for step in plan.sequence):
        return "an arm twice in a step"
    strategy, guarantee = str(plan.strategy), str(plan.guarantee)
    if strategy in ("alternated", "coordinated"):
        if len(names) != 2:
            return "two arms were meant"
    elif names != [strategy]:
        return "another arm was meant"
    is_one = all(len(step.runs) == 1 for step in plan.sequence)
    by_arm = [arm for arm, _ in runs] == [arm for arm in names for _ in LEGS]
    if guarantee == "one-at-a-time" and not (is_one and by_arm):
        return "not one arm after the other"
    if strategy != "coordinated" and guarantee != "one-at-a-time" and is_one:
        return "no two arms at once, and called otherwise"
    pairs = [[leg for _, leg in step.runs] for step in plan.sequence if len(step.runs) == 2]
    if strategy != "coordinated" and (
        guarantee == "synchronised"
        or not by_arm
        or any(pair != ["home", "reach"] for pair in pairs)
    ):
        return "arms at once where they take turns"
    return ""


def _legs(files: Files, one) -> str:
    if tuple(leg.name for leg in one.legs) != LEGS:
        return "other legs"
    if list(one.joints) != files.chains[one.arm]:
        return "other joints"
    limits = np.array([files.joints[name] for name in one.joints])
    at, home = files.home(one.arm), files.home(one.arm)
    stroke = np.array(files.tool(one.arm).get("stroke_mm", (0, 0))) / 1000
    for leg in one.legs:
        q, t = np.asarray(leg.q), np.asarray(leg.t)
        if q.ndim != 2 or len(q) < 2 or q.shape[1] != len(limits) or t.shape != (len(q),):
            return f"{leg.name}: numbers are missing"
        if not (np.isfinite(q).all() and np.isfinite(t).all()):
            return f"{leg.name}: no numbers"
        if np.abs(q[0] - at).max() > np.deg2rad(0.0101):
            return f"{leg.name}: begins elsewhere"
        at = q[-1]
        if (q < limits[:, 0] - 1e-6).any() or (q > limits[:, 1] + 1e-6).any():
            return f"{leg.name}: beyond a joint's limit"
        steps = np.rad2deg(q) * 100
        if np.abs(steps - np.round(steps)).max() > 1e-4:
            return f"{leg.name}: finer than can be sent"
        if leg.holding != (leg.name in HOLDING):
            return f"{leg.name}: holding is wrong"
        if files.tool(one.arm).get("finger") and not stroke[0] <= leg.opening <= stroke[1]:
            return f"{leg.name}: beyond the fingers' stroke"
        broken = _times(files, one, leg.name, q, t, limits[:, 2])
        if broken:
            return broken
    return "home: ends elsewhere" if np.abs(at - home).max() > np.deg2rad(0.0101) else ""


def _times(files: Files, one, name: str, q, t, speeds) -> str:
    """Mean speeds are reached somewhere between waypoints, and no way is passed too soon."""
    if t[0] != 0 or (np.diff(t) <= 0).any():
        return f"{name}: times do not increase"
    share = 1.002 / (1 - files.policy("zone"))
    velocity = speeds * files.cell["policy"]["speed"]
    means = np.diff(q, axis=0) / np.diff(t)[:, None]
    if (np.abs(means) > velocity * share).any():
        return f"{name}: too fast"
    most = np.deg2rad(files.arm(one.arm).get("acceleration_deg", 600))
    rests = [np.zeros(q.shape[1])]
    for k, (before, after) in enumerate(pairwise([*rests, *means, *rests])):
        first, last = max(k - 1, 0), min(k + 1, len(t) - 1)
        if (np.abs(after - before) > most * share * (t[last] - t[first])).any():
            return f"{name}: too hard"
    acceleration = np.full(q.shape[1], most)
    stops = [at_rest_between(step, velocity, acceleration) for step in np.diff(q, axis=0)]
    is_late = bool((np.diff(t) < SOON * np.array(stops)).any())
    zone = 0.0 if files.corners == "stop" else files.policy("zone")
    if zone > 0 and (is_late or files.corners == "streamed"):
        key = q.tobytes(), t.tobytes(), velocity.tobytes(), most, zone
        if key not in _known_times:
            _known_times[key] = all(
                _is_late(np.diff(t), soonest(q, zone, velocity, acceleration, pieces))
                for pieces in (COARSE, FINE)
            )
        is_late = _known_times[key]
    return f"{name}: too soon" if is_late else ""


def _is_late(times, soon) -> bool:
    """Whether a leg, or one way in it, would have to take longer (m,) [s]."""
    return bool((times < SOON_OF_ONE * soon).any() or times.sum() < SOON * soon.sum())


def _least_air_mm(policy) -> float | None:
    """How little room fingers may leave [mm]; None: they open as the grasp says.

    A cell that says nothing, or names no lifts, lets them open less as needed.
    """
    usual = "quick" if "lifts" in policy else "as-needed"
    air = None if policy.get("emptying", usual) == "quick" else 1.5
    return policy.get("least_air_mm", air)


def _grasp(files: Files, plan, one) -> str:
    kind = plan.detections[one.detection].part
    grasp = next(iter(files.taken_by(kind, one)), None)
    if grasp is None:
        return "no such grasp"
    if not grasp.get("enabled", True):
        return "grasp switched off"
    if grasp.get("arms") and one.arm not in grasp["arms"]:
        return "grasp for another arm"
    if grasp.get("tool") and grasp["tool"] != files.arm(one.arm)["tool"]:
        return "grasp for another tool"
    has_fingers = bool(files.tool(one.arm).get("finger"))
    for leg in one.legs:
        grip, most = grasp["grip_mm"] / 1000, grasp["opening_mm"] / 1000
        least, air = most, _least_air_mm(files.cell["policy"])
        if air is not None and has_fingers:
            least = min(most, grip + 2 * air / 1000)
        low, high = (grip, grip) if leg.name in HOLDING else (least, most)
        if not low - 2e-6 <= leg.opening <= high + 2e-6:
            return f"{leg.name}: fingers otherwise than the grasp says"
    if abs(one.leg("reach").opening - one.leg("approach").opening) > 2e-6:
        return "fingers move between two legs"
    return ""


def is_off(files: Files, scene, plan, one, hand) -> str:
    """What is wrong with where a hand is: `hand` gives its pose (4, 4) at joints (n,) [rad].

    What is known to lie on pallets is in `scene`.
    """
    kind = plan.detections[one.detection].part
    T_part = plan.detections[one.detection].T_world_part.homogeneous
    T_grasp = hand(one.leg("approach").q[-1])
    points = files.points[kind]
    T_tcp_part = np.linalg.inv(T_grasp) @ T_part
    if _apart(points, one.T_tcp_part.homogeneous, T_tcp_part) > SAID:
        return "the hand closes beside the part"
    halves = [np.eye(4)]
    if len(files.tool(one.arm).get("finger", ())) == 2:
        halves.append(np.eye(4))
        halves[1][:3, :3] = turned((0, 0, 180))
    T_put = hand(one.leg("place").q[-1])
    if one.station:
        T_lies = T_put @ np.linalg.inv(T_grasp) @ T_part
        stands = stood_on(files, one.station, kind, T_lies)
        if isinstance(stands, str):
            return stands
    elif not any(
        _apart(points, T_put @ T_tcp_part, T @ half @ T_tcp_part) <= NEAR
        for T in files.places(one.arm)
        for half in halves
    ):
        T_lies, shall = T_put @ np.linalg.inv(T_grasp) @ T_part, files.part_places(one.arm, kind)
        came = T_put[:3, 3] - hand(one.leg("place").q[0])[:3, 3]
        there = [place for place in shall if _lies(place, T_lies, files.parts[kind])]
        if not there:
            return "no place is there"
        beside = [np.linalg.norm(np.cross(came, place["comes"])) for place in there]
        if min(beside) > NEAR + 0.001 or not any(came @ place["comes"] >= 0 for place in there):
            return "it does not come from where the place has it come"
        wrong = stacked(files, scene, one.arm, kind, T_lies, _lies)
        if wrong:
            return wrong
    held = [
        grasp
        for grasp in files.taken_by(kind, one)
        if any(_as_authored(grasp, points, half @ T_tcp_part) for half in halves)
    ]
    if not held:
        return "the part is otherwise in the hand"
    wrong = [_other_way(grasp, T_part, one, hand) for grasp in held]
    return "" if "" in wrong else wrong[0]


def _other_way(grasp, T_part, one, hand) -> str:
    """The first straight leg that is none, or leads elsewhere than a grasp says."""
    turn = T_part[:3, :3] @ grasp["T"][:3, :3]
    length = grasp.get("approach_length_mm", 60) / 1000
    ways = {"approach": turn @ unit(grasp.get("approach", (0, 0, 1))) * length, "place": None}
    ways["extract"] = None
    if "retreat" in grasp:
        far = grasp.get("retreat_length_mm", 100) / 1000
        ways["extract"] = turn @ unit(grasp["retreat"]) * far
    for name, way in ways.items():
        if not _is_straight([*_dense(np.asarray(one.leg(name).q), hand)], way):
            return f"{name}: not straight, or another way"
    return ""


def _apart(points, T, other) -> float:
    """How far [m] two poses (4, 4) put any point (n, 4) of a part apart."""
    return float(np.linalg.norm(points @ (T - other).T, axis=1).max())


def _lies(place, T, part) -> bool:
    """Whether a part lies as a place asks, at some turn about its z and by some turn of its own.

    Turns about z are tried a quarter degree apart, its own by any angle a degree apart.  What
    samples miss is allowed on top.
    """
    off, step, of_its_own = np.linalg.inv(place["T"]) @ T, np.deg2rad(0.25), 1.0
    about_z = np.append(np.arange(-place["free"], place["free"], step), place["free"])
    about_z = np.array([turned((0, 0, np.rad2deg(a))) for a in about_z])
    missed = (step + np.deg2rad(of_its_own)) / 2 + 1e-6
    for S in turns(part, of_its_own):
        far = np.linalg.norm(about_z @ S[:3, 3] - off[:3, 3], axis=1)
        cosines = (np.einsum("nij,ij->n", about_z, off[:3, :3] @ S[:3, :3].T) - 1) / 2
        is_there = far <= place["far"] + missed * np.linalg.norm(S[:3, 3]) + 1e-6
        if (is_there & (np.arccos(np.clip(cosines, -1, 1)) <= place["turn"] + missed)).any():
            return True
    return False


def _as_authored(grasp, points, T_tcp_part) -> bool:
    """Whether a grasp leaves this free: a slide along x, a tilt about y, then a turn about z."""
    off = np.linalg.inv(grasp["T"]) @ np.linalg.inv(T_tcp_part)
    slide = grasp.get("slide_mm", 0) / 1000
    turn, tilt = grasp.get("free_rotation_deg", 0), grasp.get("tilt_deg", 0)
    most = np.array([slide, tilt, turn])
    tilted, turned_by = np.arctan2(off[0, 2], off[2, 2]), np.arctan2(off[1, 0], off[1, 1])
    taken = np.clip([off[0, 3], *np.rad2deg([tilted, turned_by])], -most, most)
    allowed = np.eye(4)
    allowed[:3, :3] = turned((0, taken[1], 0)) @ turned((0, 0, taken[2]))
    allowed[0, 3] = taken[0]
    return _apart(points, T_tcp_part, np.linalg.inv(grasp["T"] @ allowed)) <= NEAR


def _dense(path, hand):
    """Poses along waypoints, and whether each is at one."""
    yield hand(path[0]), True
    for a, b in pairwise(path):
        for share in np.linspace(0, 1, 13)[1:]:
            yield hand(a + share * (b - a)), share == 1


def _is_straight(poses, way) -> bool:
    start, end = poses[0][0], poses[-1][0]
    gone = end[:3, 3] - start[:3, 3]
    if way is not None and np.linalg.norm(gone - way) > ASIDE:
        return False
    along, farthest = gone / max(np.linalg.norm(gone), 1e-9), 0.0
    for T, is_waypoint in poses:
        off = T[:3, 3] - start[:3, 3]
        aside = np.linalg.norm(off - along * (along @ off))
        turn = np.arccos(np.clip((np.trace(start[:3, :3].T @ T[:3, :3]) - 1) / 2, -1, 1))
        if aside > (ASIDE if is_waypoint else ASIDE_BETWEEN) or turn > TURN:
            return False
        if along @ off < farthest - ASIDE:
            return False
        farthest = max(farthest, float(along @ off))
    return True


def leaves_straight(path, hand) -> bool:
    """Whether a hand goes straight over waypoints (m, n) [rad]."""
    return _is_straight([*_dense(np.asarray(path), hand)], None)

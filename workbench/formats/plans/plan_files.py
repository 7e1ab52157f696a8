"""Plan files: the canonical form of a plan, so that anybody can recompute its digest.

Besides the fields of `Plan` a file holds `format`, `proof` (a summary for people, or null),
`seconds` (computing time per stage) and `digest`.  It may hold `notes`, the planner's remarks as
messages.  The digest covers everything except these five.  With Python's standard library:

    content = json.loads(Path("plan.json").read_text(encoding="utf-8"))
    stated = content["digest"]
    for key in ("format", "proof", "seconds", "notes", "digest"):
        content.pop(key, None)
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    assert hashlib.sha256(text.encode()).hexdigest() == stated

A file without `digest` is one that another program made: it may leave out `proof`, `seconds`,
`seed`, `note`, `obstacles`, `cell_digest` and `scan_digest` as well, and is proven like any other.

Lengths are in m, angles in rad, times in s.
"""

from pathlib import Path
from typing import Any, get_args

import numpy as np

from workbench.formats.files.json_keys import json_text, read_json
from workbench.formats.files.toml_keys import MISSING, Table, quote
from workbench.formats.files.whole_files import write_whole
from workbench.formats.plans.pose_files import (
    MOST_PARTS,
    name_in,
    read_covariance,
    read_detection,
    read_pose_rows,
)
from workbench.model.candidate import FoundGrip
from workbench.model.digest import LARGE, canonical
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import Floats
from workbench.model.load import Load, Loads, load_problem
from workbench.model.messages.catalogue import message_of
from workbench.model.messages.message import Message
from workbench.model.plan import (
    NO_PART,
    PLAN_FORMAT,
    UNSIGNED,
    ArmPlan,
    Guarantee,
    Leg,
    LegName,
    Plan,
    Proof,
    Step,
    Strategy,
)
from workbench.model.recipes.seen_base import SeenBase, SightProblem
from workbench.model.scan import Obstacle

MOST_JOINTS = 64
MOST_OBSTACLES = 600
"""What a scan shows, and parts on pallets."""

MOST_NOTES, LONGEST_NOTE = 30, 1000

LARGEST_JOINT = 1000.0
"""[rad or m] Largest joint value in a file; a larger one is a mistake."""


def write_plan(path: str | Path, plan: Plan, proof: Proof | None = None) -> None:
    """Write a plan, with a summary of its proof when there is one.

    Raises:
        FileError: the file cannot be written, a number is not finite; or a leg has more than
            `model.digest.LARGE` numbers (it would enter the digest by its bytes, which JSON
            does not hold).
    """
    path = Path(path)
    try:
        content = plan_content(plan, proof)
    except InputError as error:
        raise FileError(path, f"not written: {error}") from error
    write_whole(path, json_text(path, content))


def plan_content(plan: Plan, proof: Proof | None = None) -> dict[str, Any]:
    """What a plan file holds, with a summary of its proof when there is one.

    Raises:
        InputError: a leg has more than `model.digest.LARGE` numbers.
    """
    for arm in plan.arms:
        for leg in arm.legs:
            if leg.q.size > LARGE:
                raise InputError(
                    f"leg {leg.name} of arm {arm.arm} has {leg.q.size} numbers, a plan file "
                    f"holds at most {LARGE} a leg"
                )
    return {
        "format": PLAN_FORMAT,
        **canonical(plan, without=UNSIGNED),
        "proof": None if proof is None else _summary(proof),
        "seconds": canonical(plan.seconds),
        **({"notes": canonical(plan.notes)} if plan.notes else {}),
        "digest": plan.digest,
    }


def read_plan(path: str | Path) -> tuple[Plan, str]:
    """A plan as it stands in a file, and the digest that the file states; see `plan_from`.

    Raises:
        FileError: names the key that is missing, not known, or of the wrong type, length or
            value.  Whether the plan fits a cell is not asked here.
    """
    return plan_from(read_json(Path(path), PLAN_FORMAT))


def plan_from(table: Table) -> tuple[Plan, str]:
    """A plan as an object of its fields, and the digest that it states.

    The digest of the returned plan is computed from what was read.  When it is not the stated
    one, the file was edited after the plan was made: that is for the caller to judge; when none is
    stated, which is empty text, another program has made it.  The proof in the file is for people
    and not read back; `prove` makes a new one.

    Raises:
        FileError: see `read_plan`.
    """
    is_foreign = not table.has("digest")

    def optional(default: Any) -> Any:
        return default if is_foreign else MISSING

    detections = tuple(read_detection(d, complete=True) for d in _few(table, "detections"))
    arms = tuple(_arm(arm, len(detections)) for arm in _few(table, "arms"))
    table.once("arms", (arm.arm for arm in arms))
    plan = Plan(
        cell=name_in(table, "cell"),
        cell_digest=table.text("cell_digest", optional(""), empty=is_foreign),
        scan_digest=table.text("scan_digest", optional(""), empty=is_foreign),
        seed=table.whole("seed", optional(0), low=0, high=2**63 - 1),
        strategy=_strategy(table, arms),
        guarantee=Guarantee(table.text("guarantee", among=tuple(Guarantee))),
        detections=detections,
        arms=arms,
        sequence=tuple(_step(step, arms) for step in _few(table, "sequence")),
        note=table.text("note", optional(""), empty=True),
        obstacles=obstacles_from(table) if table.has("obstacles") or not is_foreign else (),
        seconds=_seconds(table.table("seconds")) if table.has("seconds") or not is_foreign else {},
        notes=_notes(table),
    )
    if not table.is_null("proof") and (table.has("proof") or not is_foreign):
        table.table("proof")
    stated = table.text("digest", optional(""), empty=is_foreign)
    table.finish()
    return plan, stated


def _notes(table: Table) -> tuple[Message, ...]:
    """Remarks of the planner, which may be of another version."""
    try:
        notes = tuple(map(message_of, table.forms("notes")))
    except (KeyError, TypeError, ValueError):
        raise table.error("notes", "messages with id and args, or texts, are expected") from None
    if len(notes) > MOST_NOTES or any(len(str(note)) > LONGEST_NOTE for note in notes):
        raise table.error("notes", f"at most {MOST_NOTES} of {LONGEST_NOTE} characters are read")
    if not all(str(note).isprintable() for note in notes):
        raise table.error("notes", "holds a character that cannot be shown")
    return notes


def _strategy(table: Table, arms: tuple[ArmPlan, ...]) -> Strategy:
    """One for two arms, or the name of an arm of the plan."""
    known = (Strategy.ALTERNATED, Strategy.COORDINATED, *(arm.arm for arm in arms))
    return Strategy(table.text("strategy", among=known))


def _few(table: Table, key: str, most: int = MOST_PARTS) -> list[Table]:
    entries = list(table.tables(key, MISSING))
    if len(entries) > most:
        raise table.error(key, f"{len(entries)} are given, at most {most} are read")
    return entries


def obstacles_from(table: Table) -> tuple[Obstacle, ...]:
    """What else is in the bin, under the key `obstacles`."""
    return tuple(_obstacle(box) for box in _few(table, "obstacles", MOST_OBSTACLES))


def _obstacle(table: Table) -> Obstacle:
    T_world_box = read_pose_rows(table, "T_world_box")
    size = table.numbers("size", 3, low=1e-6, high=100.0)
    part, T_world_put = "", None
    if table.has("part") or table.has("T_world_put"):
        part, T_world_put = table.text("part"), read_pose_rows(table, "T_world_put")
    seen = _seen_base(table.table("seen")) if table.has("seen") else None
    if seen is not None and not part:
        raise table.error("seen", "is of a part of an assembly: `part` is expected")
    table.finish()
    return Obstacle(T_world_box, size, part, T_world_put, seen)


def _seen_base(table: Table) -> SeenBase:
    """What a scan shows of a part of an assembly."""
    problem = None
    if not table.is_null("problem"):
        problem = SightProblem(table.text("problem", among=tuple(SightProblem)))
    is_seen = problem is None
    seen = SeenBase(
        table.text("scan", empty=not is_seen),
        read_pose_rows(table, "T_world_part") if is_seen else None,
        read_covariance(table) if is_seen else None,
        table.number("shift", low=0, high=10),
        table.number("turn", low=0, high=4),
        table.number("visible", low=0, high=1),
        problem,
    )
    for key in ("T_world_part", "covariance"):
        if not is_seen and not table.is_null(key):
            raise table.error(key, "is stated of a part that the scan does not show")
    table.finish()
    return seen


def _arm(table: Table, detections: int) -> ArmPlan:
    joints = table.texts("joints")
    if not 0 < len(joints) <= MOST_JOINTS:
        raise table.error("joints", f"{len(joints)} are given, 1 to {MOST_JOINTS} are expected")
    table.once("joints", joints)
    legs = tuple(_leg(leg, len(joints)) for leg in _few(table, "legs"))
    table.once("legs", (leg.name for leg in legs))
    is_other = table.has("tool") or table.has("held")
    takes_part = not (is_other or any(leg.name in ("view", "stir") for leg in legs))
    if takes_part and detections == 0:
        raise table.error("detection", "the plan has no detections for it to be one of")
    low, high = (0, detections - 1) if takes_part else (NO_PART, NO_PART)
    arm = ArmPlan(
        arm=name_in(table, "arm"),
        detection=table.whole("detection", low=low, high=high),
        grasp=name_in(table, "grasp") if takes_part else table.text("grasp", "", empty=True),
        T_tcp_part=read_pose_rows(table, "T_tcp_part"),
        joints=joints,
        legs=legs,
        station=name_in(table, "station") if table.has("station") else "",
        loads=_loads(table.table("loads")) if table.has("loads") else None,
        found=_found_grip(table.table("found")) if table.has("found") else None,
        tcp=name_in(table, "tcp") if table.has("tcp") else "",
        tool=name_in(table, "tool") if table.has("tool") else "",
        held=name_in(table, "held") if table.has("held") else "",
    )
    table.finish()
    return arm


def _found_grip(table: Table) -> FoundGrip:
    grip = FoundGrip(
        T_part_tcp=read_pose_rows(table, "T_part_tcp"),
        opening=table.number("opening", low=0, high=1),
        grip=table.number("grip", low=0, high=1),
    )
    table.finish()
    return grip


def _loads(table: Table) -> Loads:
    part = None if table.is_null("part") else _load(table.table("part"))
    new_tool = _load(table.table("new_tool")) if table.has("new_tool") else None
    loads = Loads(_load(table.table("tool")), part, new_tool)
    table.finish()
    return loads


def _load(table: Table) -> Load:
    mass, centre = table.number("mass", low=1e-9, high=1e6), table.numbers("centre", 3)
    inertia = table.rows("inertia", 3)
    if problem := load_problem(mass, centre, inertia):
        raise table.error("inertia", problem)
    load = Load(mass, centre, inertia)
    table.finish()
    return load


def _leg(table: Table, joints: int) -> Leg:
    q = table.rows("q", joints)
    if not 0 < q.size <= LARGE:
        raise table.error("q", f"{len(q)} waypoints; expected 1 to {LARGE // joints}")
    if np.abs(q).max() > LARGEST_JOINT:
        raise table.error("q", f"joint values reach {np.abs(q).max():.3g}, no joint turns so far")
    leg = Leg(
        name=_leg_name(table),
        motion="linear" if table.text("motion", among=("joint", "linear")) == "linear" else "joint",
        holding=table.flag("holding"),
        opening=table.number("opening", low=0, high=1),
        q=q,
        t=_times(table, len(q)),
    )
    table.finish()
    return leg


def _leg_name(table: Table) -> LegName:
    among = get_args(LegName)
    name = table.text("name", among=among)
    return next(known for known in among if known == name)


def _times(table: Table, count: int) -> Floats:
    t = table.numbers("t", None, low=0, high=1e6)
    if len(t) != count:
        raise table.error("t", f"{len(t)} times for {count} waypoints in q")
    return t


def _step(table: Table, arms: tuple[ArmPlan, ...]) -> Step:
    """One step; every run names a leg that is there, since whoever draws a plan looks it up."""
    known: dict[tuple[str, str], LegName] = {
        (arm.arm, leg.name): leg.name for arm in arms for leg in arm.legs
    }
    runs: list[tuple[str, LegName]] = []
    for arm, leg in table.text_rows("runs", 2):
        if (arm, leg) not in known:
            said = f"there is no leg {quote(leg)} of an arm {quote(arm)} in this plan"
            raise table.error("runs", said)
        runs.append((arm, known[(arm, leg)]))
    if not runs:
        raise table.error("runs", "is empty; a step runs at least one leg")
    table.finish()
    return Step(tuple(runs))


def _seconds(table: Table) -> dict[str, float]:
    return {stage: table.number(stage, low=0) for stage in table.names()}


def _summary(proof: Proof) -> dict[str, Any]:
    return {
        "holds": proof.holds,
        **canonical(proof, without=frozenset({"clearances", "apart"})),
        "digest": proof.digest,
    }

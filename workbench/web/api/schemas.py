"""The shape of every answer, as JSON Schema; `forms` makes what fits it."""

from collections.abc import Mapping
from typing import Any

from workbench.app.core.state import Phase
from workbench.formats.plans.plan_files import PLAN_FORMAT
from workbench.model.candidate import Reason, Stage
from workbench.model.release import PickResult

Schema = Mapping[str, Any]

TEXT: Schema = {"type": "string"}
FLAG: Schema = {"type": "boolean"}
WHOLE: Schema = {"type": "integer"}
NUMBER: Schema = {"type": "number"}
DIGEST: Schema = {"type": "string", "pattern": "^[0-9a-f]{64}$"}
RESULT: Schema = {"type": "string", "enum": [str(result) for result in PickResult]}
PHASE: Schema = {"type": "string", "enum": [str(phase) for phase in Phase]}


def or_none(schema: Schema) -> Schema:
    """Null, too."""
    return {"anyOf": [schema, {"type": "null"}]}


def many(schema: Schema) -> Schema:
    """A list."""
    return {"type": "array", "items": schema}


def row_of(count: int, schema: Schema, says: str = "") -> Schema:
    """A list of exactly `count` values."""
    described = {"description": says} if says else {}
    return {"type": "array", **described, "items": schema, "minItems": count, "maxItems": count}


def record(**properties: Schema) -> Schema:
    """An object with exactly these keys."""
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


def beside(given: Schema, **properties: Schema) -> Schema:
    """The same object, which may have these keys, too."""
    return {**given, "properties": {**given["properties"], **properties}}


def by_name(schema: Schema) -> Schema:
    """An object whose keys are names."""
    return {"type": "object", "additionalProperties": schema}


POSE = row_of(4, row_of(4, NUMBER), "rows of a homogeneous matrix [m]")
POINT = row_of(3, NUMBER)

SAID = record(id=TEXT, args={"type": "object"}, text=TEXT)
"""A message: its id and arguments, see messages.html of the site, and its English text."""

VERDICT = record(
    reason={"type": "string", "enum": [reason.name for reason in Reason]},
    stage={"type": "string", "enum": [str(stage) for stage in Stage]},
    pair=or_none(many(TEXT)),
    distance=or_none(NUMBER),
    q=or_none(many(NUMBER)),
    note=TEXT,
    said=SAID,
)
PREPARING = or_none(record(done=or_none(NUMBER), note=TEXT))
"""What tasks wait for: it is done once, after an installation."""

STATE = record(
    number=WHOLE,
    phase=PHASE,
    message=TEXT,
    said=SAID,
    fault=TEXT,
    stale=TEXT,
    ran=or_none(DIGEST),
    changed=many(TEXT),
    cell=TEXT,
    cell_digest=DIGEST,
    recipe=WHOLE,
    recipes=many(record(number=WHOLE, name=TEXT)),
    bin=TEXT,
    bins=many(TEXT),
    empty_bins=many(TEXT),
    view=TEXT,
    views=many(TEXT),
    kit=or_none(
        record(
            items=many(record(part=TEXT, count=WHOLE, has=WHOLE)),
            is_complete=FLAG,
            complete_before=WHOLE,
            incomplete_before=WHOLE,
            bases=many(
                record(
                    part=TEXT,
                    scan=TEXT,
                    T_world_part=or_none(many(many(NUMBER))),
                    shift=NUMBER,
                    turn=NUMBER,
                    said=SAID,
                )
            ),
        )
    ),
    is_saved=FLAG,
    control=TEXT,
    asking=many(TEXT),
    job=or_none(WHOLE),
    getting_ready=PREPARING,
    scan=or_none(DIGEST),
    detections=or_none(WHOLE),
    wrong_parts=many(TEXT),
    wrong_sizes=many(TEXT),
    verdict=or_none(VERDICT),
    plan=or_none(DIGEST),
    strategy=or_none(TEXT),
    strategies=many(TEXT),
    holds=or_none(FLAG),
    row=many(
        record(
            plan=DIGEST,
            proof=DIGEST,
            holds=FLAG,
            clearance=or_none(NUMBER),
            cycle_seconds=NUMBER,
            parts=many(WHOLE),
            is_sent=FLAG,
        )
    ),
    row_ends=TEXT,
    row_ends_said=or_none(SAID),
    row_left_out=WHOLE,
    watched=many(TEXT),
    approved_by=many(TEXT),
    approved_unwatched=FLAG,
    approved_speed=or_none(NUMBER),
    approved_stepped=FLAG,
    step_waits=WHOLE,
    ahead=or_none(many(TEXT)),
    approved_until=or_none(NUMBER),
    messages_sent=WHOLE,
    parts_placed=WHOLE,
    outcomes=many(record(detection=WHOLE, is_picked=FLAG, by=TEXT, why=TEXT, result=RESULT)),
)
JOB = record(
    number=WHOLE,
    phase=PHASE,
    message=TEXT,
    said=SAID,
    job=or_none(record(number=WHOLE, name=TEXT, at=NUMBER, done=or_none(NUMBER), note=TEXT)),
    getting_ready=PREPARING,
)
EMPTYING = record(
    cell_digest=DIGEST,
    parts=WHOLE,
    taken=WHOLE,
    taken_share=or_none(NUMBER),
    taken_rolled=WHOLE,
    estimate_share=or_none(NUMBER),
    bound_share=or_none(NUMBER),
    picks=WHOLE,
    failed_picks=WHOLE,
    failed_by_kind=by_name(WHOLE),
    touches=WHOLE,
    warned_picks=WHOLE,
    warned_touches=WHOLE,
    knocked_out=WHOLE,
    cycles=WHOLE,
    scans=WHOLE,
    motion_seconds=NUMBER,
    parts_per_hour=or_none(NUMBER),
    planning_ms=or_none(record(median=NUMBER, p95=NUMBER)),
    planning_ms_by_stage=by_name(NUMBER),
    finding_ms=NUMBER,
    left_by_reason=by_name(WHOLE),
    scenes=many(
        record(
            seed=WHOLE,
            parts=WHOLE,
            taken=WHOLE,
            cycles=WHOLE,
            scans=WHOLE,
            failed_picks=WHOLE,
            failed_by_kind=by_name(WHOLE),
            touches=WHOLE,
            warned_picks=WHOLE,
            warned_touches=WHOLE,
            knocked_out=WHOLE,
            motion_seconds=NUMBER,
            left=many(
                record(
                    part=TEXT, kind=TEXT, reason=TEXT, said=SAID, nearest_fix=TEXT, any_grasp=TEXT
                )
            ),
        )
    ),
    what_if=many(
        record(
            change=TEXT,
            said=SAID,
            taken_share_before=or_none(NUMBER),
            taken_share=or_none(NUMBER),
            parts_gained=WHOLE,
            taken_by_scene=many(WHOLE),
            failed_picks=WHOLE,
            touches=WHOLE,
            cycles=WHOLE,
            motion_seconds=NUMBER,
            left_by_reason=by_name(WHOLE),
        )
    ),
)
"""As `workbench study emptying --json` prints it."""
DONE = record(number=WHOLE, phase=PHASE, message=TEXT, job=or_none(WHOLE))
PERSON = record(name=TEXT, role=TEXT, may=many(TEXT))
SCAN = record(
    digest=DIGEST,
    source=TEXT,
    at=NUMBER,
    points=WHOLE,
    resolution=or_none(many(WHOLE)),
    T_world_scanner=POSE,
    low=POINT,
    high=POINT,
    views=many(
        record(
            name=TEXT,
            points=WHOLE,
            T_world_scanner=POSE,
            shift=NUMBER,
            turn=NUMBER,
            looked_through=NUMBER,
            is_off=FLAG,
        )
    ),
)
COVARIANCE = row_of(
    6,
    row_of(6, NUMBER),
    "of shifts of the part's origin [m] and turns about it [rad], world axes",
)
DETECTIONS = many(
    beside(
        record(
            part=TEXT,
            T_world_part=POSE,
            score=NUMBER,
            visible=NUMBER,
            gap=or_none(NUMBER),
            residual=or_none(NUMBER),
            roll_known=FLAG,
        ),
        covariance=COVARIANCE,
        probability=NUMBER,
        roll_axis=many(POINT),
        by_colour=FLAG,
    )
)
CANDIDATES = many(
    record(
        detection=WHOLE,
        grasp=TEXT,
        arm=TEXT,
        tcp=TEXT,
        rank=or_none(NUMBER),
        T_world_tcp=POSE,
        verdict=VERDICT,
    )
)
PLAN: Schema = {
    "type": "object",
    "description": f"a plan as its file has it, {PLAN_FORMAT}",
    "properties": {"format": {"const": PLAN_FORMAT}, "digest": DIGEST},
    "required": ["format", "digest", "arms", "sequence", "proof"],
}
PLACE_OF_PROOF = record(
    problem=TEXT,
    said=SAID,
    arm=TEXT,
    leg=TEXT,
    waypoint=or_none(WHOLE),
    pair=or_none(many(TEXT)),
    distance=or_none(NUMBER),
)
PROOF = record(
    digest=DIGEST,
    plan=DIGEST,
    holds=FLAG,
    checks=WHOLE,
    resolution=or_none(NUMBER),
    clearance=or_none(NUMBER),
    nearest=or_none(PLACE_OF_PROOF),
    violations=many(PLACE_OF_PROOF),
    speeds=many(record(arm=TEXT, leg=TEXT, tcp=or_none(NUMBER), point=or_none(NUMBER))),
)
STATISTICS = record(
    cycles=WHOLE,
    picked=WHOLE,
    picks_per_hour=or_none(NUMBER),
    rates=by_name(by_name(record(**{str(result): WHOLE for result in PickResult}))),
    refusals=by_name(WHOLE),
    kits=many(record(recipe=WHOLE, complete=WHOLE, incomplete=WHOLE)),
    stages=by_name(record(median=NUMBER, largest=NUMBER)),
)
COMMISSIONING = many(record(step=TEXT, is_done=FLAG, text=TEXT, said=SAID))
SESSIONS = record(current=TEXT, sessions=many(TEXT))
PROBLEM = beside(record(title=TEXT, status=WHOLE, detail=TEXT), said=SAID)

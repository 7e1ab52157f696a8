"""Certificates: a proof as a file that another machine checks without searching for anything.

A certificate holds the plan, what was known to be in the bin, what the proof said of every leg; and
for which cell, software and libraries it was made.  Checking it asks whether all of that is so,
which takes less time than finding it; nothing in it is believed.

Lengths are in m, angles in rad.
"""

import importlib.metadata
import platform
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from workbench.formats.files.json_keys import json_text, read_json
from workbench.formats.files.toml_keys import MISSING, Table
from workbench.formats.files.whole_files import write_whole
from workbench.formats.plans.plan_files import obstacles_from, plan_content, plan_from
from workbench.formats.plans.pose_files import MOST_PARTS, read_detection
from workbench.model.digest import canonical, digest_of
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import Floats
from workbench.model.plan import PLAN_FORMAT, Plan, Proof
from workbench.model.scan import Scene

CERTIFICATE_FORMAT = "workbench-certificate/1"

LIBRARIES = ("numpy", "numba", "pin", "coal")
"""What a proof is computed with."""


@dataclass(frozen=True, slots=True, eq=False)
class Certificate:
    """A plan, the scene it was proven in, what the proof said, and what it was made with."""

    plan: Plan
    scene: Scene
    proof: Proof
    made_with: dict[str, str]


def versions() -> dict[str, str]:
    """The software that proofs are made with here: name -> version."""
    found = {"workbench": importlib.metadata.version("workbench")}
    found["python"], found["processor"] = platform.python_version(), platform.machine()
    for name in LIBRARIES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "unknown"
    return found


def write_certificate(path: str | Path, plan: Plan, scene: Scene, proof: Proof) -> None:
    """Write what was proven of a plan.

    Raises:
        InputError: the proof does not hold.
        FileError: the file cannot be written, or the plan is one that no file holds.
    """
    write_whole(Path(path), json_text(Path(path), certificate_content(plan, scene, proof)))


def certificate_content(
    plan: Plan, scene: Scene, proof: Proof, made_with: dict[str, str] | None = None
) -> dict[str, Any]:
    """What a certificate holds of a plan that was proven in a scene.

    Args:
        plan: that was proven.
        scene: what was known to be in the bin.
        proof: of the plan; it holds.
        made_with: the software that it was proven with; None: that of here.

    Raises:
        InputError: the proof does not hold, or is of another plan.
    """
    if not proof.holds:
        raise InputError("the proof does not hold, so there is nothing to certify")
    if proof.plan_digest != plan.digest:
        raise InputError("the proof is that of another plan")
    content = _content(plan, scene, proof, versions() if made_with is None else made_with)
    return {**content, "digest": digest_of(content)}


def certificate_bytes(
    plan: Plan, scene: Scene, proof: Proof, made_with: dict[str, str] | None = None
) -> bytes:
    """A certificate as its file is, for who takes it elsewhere; see `certificate_content`."""
    return json_text(Path("certificate"), certificate_content(plan, scene, proof, made_with))


def read_certificate(path: str | Path) -> Certificate:
    """A certificate as it stands in a file; whether what it says is so is not asked here.

    Raises:
        FileError: it is no certificate, or was changed after it was made.
    """
    table = read_json(Path(path), CERTIFICATE_FORMAT)
    made = table.table("made_with")
    made_with = {name: made.text(name) for name in made.names()}
    inside = table.table("plan")
    inside.text("format", among=(PLAN_FORMAT,))
    plan, stated = plan_from(inside)
    scene = _scene(table.table("scene"))
    proof = _proof(table.table("proof"), plan)
    digest = table.text("digest")
    table.finish()
    if stated != plan.digest or digest != digest_of(_content(plan, scene, proof, made_with)):
        raise FileError(Path(path), "was changed after the certificate was made")
    return Certificate(plan, scene, proof, made_with)


def _content(plan: Plan, scene: Scene, proof: Proof, made_with: dict[str, str]) -> dict[str, Any]:
    """What a certificate holds, except for its digest."""
    return {
        "format": CERTIFICATE_FORMAT,
        "made_with": made_with,
        "plan": plan_content(plan),
        "scene": canonical(scene),
        "proof": {
            "resolution": proof.resolution,
            "clearance": proof.clearance,
            "clearances": [
                {"arm": arm, "leg": leg, "at_least": bounds.tolist()}
                for arm, leg, bounds in proof.clearances
            ],
        },
    }


def _scene(table: Table) -> Scene:
    parts = list(table.tables("detections", MISSING))
    if len(parts) > MOST_PARTS:
        raise table.error("detections", f"{len(parts)} are given, at most {MOST_PARTS} are read")
    detections = tuple(read_detection(part, complete=True) for part in parts)
    scene = Scene(table.text("scan_digest"), detections, obstacles_from(table))
    table.finish()
    return scene


def _proof(table: Table, plan: Plan) -> Proof:
    proof = Proof(
        plan_digest=plan.digest,
        cell_digest=plan.cell_digest,
        scan_digest=plan.scan_digest,
        checks=0,
        resolution=table.number("resolution", low=1e-6, high=0.01),
        clearance=table.number("clearance", low=-1.0, high=1.0),
        nearest=None,
        violations=(),
        clearances=tuple(_leg(clearance) for clearance in table.tables("clearances", MISSING)),
    )
    table.finish()
    return proof


def _leg(table: Table) -> tuple[str, str, Floats]:
    bounds = table.numbers("at_least", None, low=-10.0, high=10.0)
    leg = table.text("arm"), table.text("leg"), np.asarray(bounds)
    table.finish()
    return leg

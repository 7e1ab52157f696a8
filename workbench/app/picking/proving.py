"""Proves a plan with a scan or with given poses, and checks a certificate."""

from collections.abc import Sequence
from dataclasses import replace

from workbench.app.standing.seen_again import as_scan_shows
from workbench.formats.plans.certificates import Certificate
from workbench.model.cell import Cell
from workbench.model.derived.assembling import standing_parts
from workbench.model.derived.by_tcp import has_tcp, with_tcp
from workbench.model.digest import digest_of
from workbench.model.load import loads_of
from workbench.model.plan import ArmPlan, Plan, Proof
from workbench.model.scan import Detection, Scan, Scene
from workbench.proof.claims import prove as layer


def prove(
    cell: Cell,
    plan: Plan,
    *,
    detections: Sequence[Detection] | None = None,
    scan: Scan | None = None,
    resolution: float = layer.RESOLUTION,
) -> Proof:
    """Check everything about a plan again, by code that shares nothing with planning.

    For what this guarantees, and what not, see `docs/proof.md`.

    Args:
        cell: the present cell.
        plan: as planned, or as another program made it; see `adopt_plan`.
        detections: see `scene_of`.
        scan: see `scene_of`.
        resolution: [m] see `docs/proof.md`.
    """
    scene = scene_of(cell, plan, detections=detections, scan=scan)
    return layer.prove(cell, scene, plan, resolution=resolution)


def scene_of(
    cell: Cell,
    plan: Plan,
    *,
    detections: Sequence[Detection] | None = None,
    scan: Scan | None = None,
) -> Scene:
    """What is known to be in the bin when a plan is checked.

    A part that the plan does not list becomes an obstacle, like unknown objects in the scan.  A
    part that the scan does not show does not count.  Nor does a part that another plan must put
    there first: such a plan is proven in its row.  Parts on pallets with layers are taken from the
    plan, as no scan shows them.  A base that the plan has from a scan is compared with that scan.

    Args:
        cell: the present cell.
        plan: the plan.
        detections: the parts known to be in the bin; None: those of the plan's parts that the scan
            shows.
        scan: the scan with these parts; without it, other obstacles are taken from the plan.
    """
    known = tuple(detection for detection in plan.detections if detection.T_world_found is None)
    found = known if detections is None else tuple(detections)
    digest = digest_of(found)
    # A plan for poses is named after these, also where a scan shows what else there is.
    if scan is not None and plan.scan_digest != digest:
        digest = scan.digest
    elif detections is None:
        digest = plan.scan_digest
    obstacles = plan.obstacles
    if scan is not None:
        # Brings Open3D along, which takes longer to load than a proof takes.
        from workbench.perception.scene.unexplained import unexplained

        # What lies on pallets no scan of the bin shows: the plan's word is taken for it.
        kept = as_scan_shows(cell, scan, plan.obstacles)
        obstacles = (*unexplained(cell, scan, found, standing_parts(cell, kept)), *kept)
        if detections is None:
            found = _select_shown(cell, scan, found)
    return Scene(digest, found, obstacles)


def _select_shown(cell: Cell, scan: Scan, parts: tuple[Detection, ...]) -> tuple[Detection, ...]:
    """Those of some parts that a scan shows."""
    from workbench.perception.scene.shown_parts import shown

    return tuple(part for part, is_shown in zip(parts, shown(cell, scan, parts), strict=True)
                 if is_shown)  # fmt: skip


def adopt_plan(cell: Cell, plan: Plan, scan: Scan | None = None) -> Plan:
    """A plan of another program without digests, completed for this cell and scan.

    Values that the plan states stay, so that a plan for another cell is detected.  Missing loads
    are those of the cell.
    """
    seen = digest_of(plan.detections) if scan is None else scan.digest
    arms = tuple(_with_loads(cell, plan, arm) for arm in plan.arms)
    return replace(
        plan,
        arms=arms,
        cell_digest=plan.cell_digest or cell.digest,
        scan_digest=plan.scan_digest or seen,
    )


def _with_loads(cell: Cell, plan: Plan, arm_plan: ArmPlan) -> ArmPlan:
    if not arm_plan.takes_part:
        return arm_plan
    kinds = {part.name: part for part in cell.parts}
    part = kinds.get(plan.detections[arm_plan.detection].part)
    arm = next((arm for arm in cell.arms if arm.name == arm_plan.arm), None)
    # What the cell does not have, the proof objects to.
    if arm_plan.loads is not None or part is None or arm is None:
        return arm_plan
    if not has_tcp(arm.tool, arm_plan.tcp):
        return arm_plan
    tool = with_tcp(arm.tool, arm_plan.tcp)
    return replace(arm_plan, loads=loads_of(tool, part, arm_plan.T_tcp_part))


def check(cell: Cell, certificate: Certificate, scan: Scan | None = None) -> Proof:
    """Check every statement of a certificate, without searching for a proof.

    Args:
        cell: the present cell.
        certificate: the certificate; every value is checked.
        scan: for which it must hold; None: the scene of the certificate.
    """
    plan, scene, proof = certificate.plan, certificate.scene, certificate.proof
    if scan is not None:
        scene = scene_of(cell, plan, detections=scene.detections, scan=scan)
        scene = replace(scene, detections=_select_shown(cell, scan, scene.detections))
    resolution = min(proof.resolution, layer.RESOLUTION)
    return layer.prove(cell, scene, plan, resolution=resolution, stated=proof)

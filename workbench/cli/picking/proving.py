"""`workbench prove` and `workbench verify`: whether a plan may be run, and a certificate of it."""

from dataclasses import replace
from pathlib import Path

from workbench.app.picking import proving
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments import top as arguments
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.picking.planning import cell_of, detections_from
from workbench.cli.picking.results import proof_form, proof_words
from workbench.cli.terminal import print_json, progress
from workbench.formats.clouds.scans import read_scan
from workbench.formats.plans.certificates import read_certificate, versions, write_certificate
from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.messages.proofs import ProofText
from workbench.model.plan import Plan, Proof, Violation
from workbench.plugins.misfit import misfit


def verify(typed: arguments.Verify) -> int:
    """Prove a plan from its file, and that nobody has changed the file."""
    return _proven(typed.plan, typed)


def prove(typed: arguments.Prove) -> int:
    """Prove a plan and certify it, or check a certificate."""
    if typed.check is not None:
        besides = (typed.plan, typed.poses, typed.part, typed.certificate, typed.out)
        if any(plan is not None for plan in besides):
            raise InputError("--check takes a certificate, and --scan beside it; nothing else")
        return _check(typed.check, typed)
    if typed.plan is None:
        raise InputError("name the file of a plan, or a certificate with --check")
    return _proven(typed.plan, typed, typed.certificate, typed.out)


def _proven(
    path: Path,
    typed: arguments.Prove | arguments.Verify,
    certificate: Path | None = None,
    out: Path | None = None,
) -> int:
    plan, stated = read_plan(path)
    cell = cell_of(plan, typed.cell)
    with progress("verify") as report:
        make_ready(report, ("planning",))
        report(0.0, "proving the plan")
        scan = None if typed.scan is None else read_scan(typed.scan, cell.scanner)
        poses = None if typed.poses is None else detections_from(cell, typed.poses, typed.part)
        if not stated:
            plan = proving.adopt_plan(cell, plan, scan)
        proof = proving.prove(cell, plan, detections=poses, scan=scan)
    if stated and stated != plan.digest:
        edited = Violation(ProofText.EDITED(stated=stated[:12], actual=plan.digest[:12]))
        proof = replace(proof, violations=(edited, *proof.violations))
    proof = _for_controller(cell, plan, proof)
    if proof.holds and certificate is not None:
        scene = proving.scene_of(cell, plan, detections=poses, scan=scan)
        write_certificate(certificate, plan, scene, proof)
    if proof.holds and out is not None:
        write_plan(out, plan, proof)
    if typed.json:
        form = {"ok": proof.holds, "file": str(path), "stated_digest": stated or None}
        print_json({**form, "digest": plan.digest, "proof": proof_form(proof)})
    else:
        foreign = "" if stated else f" (by another program; its digest is {plan.digest})"
        print(f"{path}{foreign}: {proof_words(proof)}")
    return SUCCESS if proof.holds else NO_PLAN


def _check(path: Path, typed: arguments.Prove) -> int:
    found = read_certificate(path)
    cell = cell_of(found.plan, typed.cell)
    with progress("check") as report:
        make_ready(report, ("planning",))
        report(0.0, "checking the certificate")
        scan = None if typed.scan is None else read_scan(typed.scan, cell.scanner)
        proof = proving.check(cell, found, scan)
    proof = _for_controller(cell, found.plan, proof)
    here = versions()
    other = {
        name: version for name, version in found.made_with.items() if here.get(name) != version
    }
    if typed.json:
        form = {"ok": proof.holds, "file": str(path), "digest": found.plan.digest}
        form |= {"cell_digest": found.plan.cell_digest, "scan_digest": found.scene.scan_digest}
        print_json({**form, "made_with": found.made_with, "proof": proof_form(proof)})
    else:
        print(f"{path}: {proof_words(proof)}")
        print(f"  plan {found.plan.digest}")
        print(f"  cell {found.plan.cell} {found.plan.cell_digest}")
        print(f"  scan {found.scene.scan_digest}")
        for number, detection in enumerate(found.scene.detections, 1):
            if detection.T_world_found is not None:
                print(f"  holds only after a plan that puts part-{number} where it stands")
        made_with = ", ".join(f"{name} {version}" for name, version in found.made_with.items())
        print(f"  made with {made_with}")
        if other:
            print(f"  checked with {', '.join(f'{name} {here.get(name)}' for name in other)}")
    return SUCCESS if proof.holds else NO_PLAN


def _for_controller(cell: Cell, plan: Plan, proof: Proof) -> Proof:
    """The proof with what the cell's controller cannot do: what holds may be run there."""
    problem = misfit(plan, cell) if proof.holds else None
    return replace(proof, violations=(Violation(problem),)) if problem else proof

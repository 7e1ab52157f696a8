"""Whether the loads that the controller will get are those of the arms in the present cell.

`planning` takes them from `model.load`; the proof computes them independently, by Pinocchio's
inertias and by integrals over surfaces.
"""

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell, Tool
from workbench.model.geometry import Box, Capsule, Cylinder, Floats, Mesh, Solid, Sphere, finest
from workbench.model.load import Load, is_closed
from workbench.model.messages.proofs import ProofText
from workbench.model.part import Part
from workbench.model.plan import ArmPlan, Plan, Violation
from workbench.model.tools.held_body import HeldAmount, held_radius
from workbench.proof.claims.tolerances import STATED

LOAD_TOLERANCE = 1e-6
"""[share] Of mass, distance and inertia, by which two computations may differ."""

LEAST_SIZE = 0.01
"""[m] Smaller bodies are compared as if they had this size."""

THIN = 1e-6
"""[share] A surface that bounds less of the box around it bounds no body."""


def load_violations(cell: Cell, plan: Plan, arm_plan: ArmPlan) -> Iterator[Violation]:
    """Whether a plan states the loads of an arm's tool and part, or rightly none.

    What a hand drops back counts as the heaviest part, or two of it, about the TCP.
    """
    if plan.is_tool_plan:
        yield from _change_violations(cell, arm_plan)
        return
    tool, loads = cell.arm(arm_plan.arm).tool, arm_plan.loads
    if tool.mass is None:
        if loads is not None:
            yield Violation(ProofText.NO_LOAD_KNOWN(tool=tool.name), arm_plan.arm)
        return
    if loads is None:
        yield Violation(ProofText.NO_LOAD_STATED(tool=tool.name), arm_plan.arm)
        return
    if not _is_alike(loads.tool, _of_tool(tool), 0.0):
        yield Violation(ProofText.TOOL_LOAD(), arm_plan.arm)
    if plan.is_drop_plan:
        meant = _of_held(cell, tool, HeldAmount(arm_plan.held))
        is_meant = loads.part is not None and _is_alike(loads.part, meant, 0.0)
    elif not arm_plan.takes_part:
        is_meant = loads.part is None
    else:
        part = cell.part(plan.detections[arm_plan.detection].part)
        meant = (tool.T_flange_tcp * arm_plan.T_tcp_part).act(_of_part(part))
        is_meant = loads.part is not None and _is_alike(loads.part, meant, STATED)
    if not is_meant or loads.new_tool is not None:
        yield Violation(ProofText.PART_LOAD(), arm_plan.arm)


def _of_held(cell: Cell, tool: Tool, held: HeldAmount) -> pin.Inertia:
    """The heaviest part, or two, as a ball about the TCP of half the reach of one."""
    count = 1 if held is HeldAmount.ONE else 2
    mass = count * max(part.mass for part in cell.parts)
    radius = held_radius(cell, HeldAmount.ONE) / 2
    return tool.T_flange_tcp.act(pin.Inertia.FromSphere(mass, radius))


def _change_violations(cell: Cell, arm_plan: ArmPlan) -> Iterator[Violation]:
    """Whether a plan that changes a tool states the loads of both, or rightly none."""
    arm, loads = cell.arm(arm_plan.arm), arm_plan.loads
    tools = arm.tool, next(tool for tool in arm.tools if tool.name == arm_plan.tool)
    unknown = [tool.name for tool in tools if tool.mass is None]
    if unknown and loads is not None:
        yield Violation(ProofText.NO_LOAD_KNOWN(tool=unknown[0]), arm_plan.arm)
    if unknown:
        return
    if loads is None or loads.new_tool is None:
        yield Violation(ProofText.NO_LOAD_STATED(tool=tools[1].name), arm_plan.arm)
        return
    stated = zip((loads.tool, loads.new_tool), tools, strict=True)
    if loads.part is not None or not all(_is_alike(load, _of_tool(t), 0.0) for load, t in stated):
        yield Violation(ProofText.TOOL_LOAD(), arm_plan.arm)


def _is_alike(stated: Load, meant: pin.Inertia, off: float) -> bool:
    """Whether loads are the same, of bodies that are stated up to `off` [m] from their place."""
    size = max(float(np.linalg.norm(meant.lever)), LEAST_SIZE)
    # What is stated a little turned has its moments turned as little.
    turned = float(np.abs(meant.inertia).max()) * off / LEAST_SIZE
    moments = LOAD_TOLERANCE * meant.mass * size**2 + turned
    return (
        abs(stated.mass - meant.mass) <= LOAD_TOLERANCE * meant.mass
        and float(np.abs(stated.centre - meant.lever).max()) <= LOAD_TOLERANCE * size + off
        and float(np.abs(stated.inertia - meant.inertia).max()) <= moments
    )


@lru_cache(maxsize=64)
def _of_tool(tool: Tool) -> pin.Inertia:
    assert tool.mass is not None
    even = _even([*tool.body, *(finger.solid for finger in tool.fingers)], tool.mass)
    centre = even.lever if tool.centre_of_gravity is None else tool.centre_of_gravity
    inertia = even.inertia if tool.inertia is None else tool.inertia
    return pin.Inertia(tool.mass, np.array(centre), np.array(inertia))


@lru_cache(maxsize=256)
def _of_part(part: Part) -> pin.Inertia:
    if is_closed(part.mesh):
        return _even([Solid(part.name, part.mesh, pin.SE3.Identity())], part.mass)
    return _even(finest(part.pieces), part.mass)


def _even(solids: Sequence[Solid], mass: float) -> pin.Inertia:
    """Solids of one density and of this mass [kg] in all."""
    bodies = [solid.T_owner_shape.act(_unit_density_inertia(solid)) for solid in solids]
    whole = bodies[0]
    for body in bodies[1:]:
        whole = whole + body
    share = mass / whole.mass
    return pin.Inertia(mass, whole.lever, whole.inertia * share)


def _unit_density_inertia(solid: Solid) -> pin.Inertia:
    """The inertia of a solid in its shape's frame, with a density of 1 kg/m3."""
    match solid.shape:
        case Box(size=size):
            x, y, z = map(float, size)
            return pin.Inertia.FromBox(x * y * z, x, y, z)
        case Sphere(radius=radius):
            return pin.Inertia.FromSphere(4 / 3 * np.pi * radius**3, radius)
        case Cylinder(radius=radius, length=length):
            return pin.Inertia.FromCylinder(np.pi * radius**2 * length, radius, length)
        case Capsule(radius=radius, length=length):
            volume = np.pi * radius**2 * (length + 4 / 3 * radius)
            return pin.Inertia.FromCapsule(volume, radius, length)
        case _:
            return _of_surface(solid.shape)


def _of_surface(mesh: Mesh) -> pin.Inertia:
    """By Gauss: of a polynomial of degree k the integral over the body is one over its surface.

    On each triangle three points, the middles of its edges, give that up to k = 2 exactly.
    """
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    a, b, c = (mesh.points[mesh.triangles[:, k]] - low for k in range(3))
    normals = np.cross(b - a, c - a) / 2
    flux = np.einsum("ij,ij->i", a, normals) / 3
    middles: list[Floats] = [(a + b) / 2, (b + c) / 2, (c + a) / 2]
    volume = float(flux.sum())
    if volume <= THIN * float(np.prod(high - low)):
        x, y, z = map(float, np.maximum(high - low, 1e-6))
        box = pin.Inertia.FromBox(x * y * z, x, y, z)
        return pin.SE3(np.eye(3), (low + high) / 2).act(box)
    first = sum((flux / 4 @ m for m in middles), np.zeros(3))
    second = sum((np.einsum("t,ti,tj->ij", flux / 5, m, m) for m in middles), np.zeros((3, 3)))
    centre = first / volume
    about = second - volume * np.outer(centre, centre)
    inertia = np.trace(about) * np.eye(3) - about
    return pin.Inertia(volume, centre + low, (inertia + inertia.T) / 2)

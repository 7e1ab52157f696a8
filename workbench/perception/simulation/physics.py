"""A bin and its parts as MuJoCo knows them."""

from collections.abc import Sequence

import mujoco
import numpy as np
import pinocchio as pin

from workbench.model.errors import InputError
from workbench.model.geometry import Box, Capsule, Cylinder, Mesh, Solid, Sphere, finest
from workbench.model.messages.parts import PileText
from workbench.model.part import Bin, Part
from workbench.perception.views.surfaces import triangles_of

TIMESTEP = 0.002

MOST_PIECES = 32
"""Of a part that is simulated with its finest pieces."""

MEMORY = 1 << 28
"""[bytes] For contacts: where it does not suffice MuJoCo drops some, and parts fall through the
floor.  Its own estimate is too small for flat parts of many pieces.  Only what is used is taken."""

FULL_WARNINGS = (mujoco.mjtWarning.mjWARN_CONTACTFULL, mujoco.mjtWarning.mjWARN_CNSTRFULL)
"""Warnings of MuJoCo that it has dropped contacts."""

LONGEST_SETTLING = 4.0
"""[s] of simulated time after the last drop, if the parts do not come to rest before."""

CONVERGED = 0.01
"""[m/s] and, over the part's radius, [rad/s]: slower than this is lying still."""

LOST = -0.1
"""[m] What is so deep under the floor has fallen off and goes on falling."""


def model_of(
    parts: Sequence[Part],
    bin: Bin,
    carried: int | None = None,
    *,
    no_slip: int = 0,
    around: Sequence[Solid] = (),
    hand: Sequence[Solid] = (),
) -> mujoco.MjModel:
    """Bin and parts as MuJoCo sees them; the world frame is that of the bin.

    Args:
        parts: each is a body by its number.
        bin: stands still.
        carried: number of a part that goes where it is put and pushes what is in its way; the
            others move freely, and are weightless until their `body_gravcomp` is 0.
        no_slip: iterations of the search for forces without slip.
        around: what else stands still, in the bin's frame.
        hand: what goes where it is put, in its own frame; none where a part is carried.
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = TIMESTEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.noslip_iterations = no_slip
    spec.memory = MEMORY
    for solid in (*bin.solids, *around):
        add_solid(spec, spec.worldbody, solid)
    for number, part in enumerate(parts):
        if number == carried:
            body = spec.worldbody.add_body(name=str(number), mocap=True)
        else:
            body = spec.worldbody.add_body(name=str(number), gravcomp=1.0)  # until it falls
            body.add_freejoint()
        for solid in _solids(part):
            add_solid(spec, body, solid)
    if hand:
        moved = spec.worldbody.add_body(name="hand", mocap=True)
        for solid in hand:
            add_solid(spec, moved, solid)
    model = spec.compile()
    # Pieces may overlap, so their volumes tell how the mass is spread but not how much it is.
    masses, of_parts = np.array([part.mass for part in parts]), slice(1, len(parts) + 1)
    model.body_inertia[of_parts] *= (masses / model.body_mass[of_parts])[:, None]
    model.body_mass[of_parts] = masses
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def _solids(part: Part) -> tuple[Solid, ...]:
    """What falls: a part's pieces, or what goes around them where they are many."""
    pieces = finest(part.pieces)
    return pieces if len(pieces) <= MOST_PIECES else part.pieces


def add_solid(spec: mujoco.MjSpec, body: mujoco.MjsBody, solid: Solid) -> mujoco.MjsGeom:
    """The solid as what a body is made of."""
    quaternion = pin.Quaternion(solid.T_owner_shape.rotation)
    geom = body.add_geom(
        pos=solid.T_owner_shape.translation,
        quat=[quaternion.w, quaternion.x, quaternion.y, quaternion.z],
        friction=[0.4, 0.002, 0.0005],
        condim=6,  # with rolling friction, or cylinders would never stop
        solref=[2.5 * TIMESTEP, 1.0],  # as stiff as the time step allows
        solimp=[0.95, 0.99, 0.0005, 0.5, 2.0],
    )
    match solid.shape:
        case Box(size=size):
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_BOX, size / 2
        case Cylinder(radius=radius, length=length):
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_CYLINDER, [radius, length / 2, 0]
        case Capsule(radius=radius, length=length):
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_CAPSULE, [radius, length / 2, 0]
        case Sphere(radius=radius):
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_SPHERE, [radius, 0, 0]
        case Mesh():
            name = f"mesh{len(spec.meshes)}"
            surface = triangles_of(solid.shape)
            spec.add_mesh(
                name=name,
                uservert=np.asarray(surface.vertices, dtype=np.float32).ravel(),
                userface=np.asarray(surface.faces, dtype=np.int32).ravel(),
            )
            geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, name
    return geom


def advance(model: mujoco.MjModel, data: mujoco.MjData, steps: int = 1) -> None:
    """Let `steps` of `TIMESTEP` pass.

    Raises:
        InputError: memory does not suffice for the contacts, so where parts lie is not known.
    """
    try:
        mujoco.mj_step(model, data, nstep=steps)
    except mujoco.FatalError:
        raise InputError(PileText.CONTACTS()) from None
    if any(data.warning[kind].number for kind in FULL_WARNINGS):
        raise InputError(PileText.CONTACTS())


def come_to_rest(model: mujoco.MjModel, data: mujoco.MjData, radius: float) -> None:
    """Let time pass until all parts lie still, or fall; `radius` [m] is that of the largest."""
    speed, place = data.qvel.reshape(-1, 6), data.qpos.reshape(-1, 7)
    for _ in range(round(LONGEST_SETTLING / TIMESTEP / 25)):
        advance(model, data, 25)
        there = np.abs(speed[place[:, 2] > LOST]) * ([1.0] * 3 + [radius] * 3)
        if there.max(initial=0.0) < CONVERGED:
            break


def poses_of(data: mujoco.MjData) -> list[pin.SE3]:
    """T_bin_part of all parts that move freely, in their order."""
    return [
        pin.SE3(pin.Quaternion(w, x, y, z).normalized().matrix(), position.copy())
        for *position, w, x, y, z in data.qpos.reshape(-1, 7)
        for position in [np.array(position)]
    ]

"""Parts dropped into a bin and left to settle: how they come to lie in production."""

from collections.abc import Sequence
from itertools import cycle, islice

import mujoco
import numpy as np
import pinocchio as pin

from workbench.model.cell import Bin, Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Box, Capsule, Cylinder, Floats, Mesh, Solid, Sphere
from workbench.model.part import Part
from workbench.model.scan import ALL_KINDS, Detection
from workbench.perception.views.surfaces import surface_of

TIMESTEP = 0.002
BETWEEN_DROPS = 0.35
"""[s] of simulated time."""

LONGEST = 4.0
"""[s] of simulated time after the last drop, if the parts do not come to rest before."""

AT_REST = 0.01
"""[m/s] and, over the part's radius, [rad/s]: slower than this is lying still."""

ATTEMPTS = 10

FULL = 0.6
"""Share of the bin that parts can fill: long ones lie more loosely than that."""

OUTSIDE = 0.001
"""[m] How far a part may reach into a wall or the floor (contacts yield a little)."""


def pile_of(cell: Cell, kind: str, count: int, *, seed: int) -> tuple[Detection, ...]:
    """Parts that fell into the cell's bin: `count` of a kind, of the first one when it is empty.

    Of the kind `ALL_KINDS` is one of each in turn.

    Raises:
        InputError: the cell has no part, or none of that kind; or they do not fit.
    """
    if not cell.parts:
        raise InputError(f"cell {cell.name} has no part, so there is nothing to drop into its bin")
    kinds = cell.parts if kind == ALL_KINDS else (cell.part(kind or cell.parts[0].name),)
    return drop_parts(tuple(islice(cycle(kinds), count)), cell.bin, seed=seed)


def drop_parts(parts: Sequence[Part], bin: Bin, *, seed: int) -> tuple[Detection, ...]:
    """Where parts come to lie that fall into the bin one after another.

    MuJoCo simulates them as unions of their convex pieces.  They start in random attitudes at
    places spread over the bin.  When a part ends up outside, all is repeated with a seed
    derived from the given one.

    Args:
        parts: what falls, in this order, a part as often as it falls; its `pieces` give the
            shape and its `mass` the inertia.
        bin: where to.
        seed: the same seed gives the same poses on the same machine.

    Returns:
        The truth: each part's pose, in the order in which they fell.

    Raises:
        InputError: a part that does not fit, or too many for the bin.
    """
    if not parts:
        return ()
    count, radius = len(parts), max(_radius(part) for part in parts)
    what = f"{count} parts {', '.join(dict.fromkeys(part.name for part in parts))}"
    for part in parts:
        if 2 * _radius(part) > float(np.linalg.norm(bin.size[:2])):
            raise InputError(f"part {part.name} is too large for the bin")
    room = float(np.prod(bin.size)) * FULL
    volume = sum(_volume(part) for part in parts)
    if volume > room:
        most = int(count * room / volume)
        raise InputError(f"{what} do not fit into the bin; take {most} or fewer")
    model = _model(parts, bin)
    for attempt in range(ATTEMPTS):
        generator = np.random.default_rng([seed, attempt])
        Ts_bin_part = _settle(model, _starts(bin, count, radius, generator), radius)
        fallen = list(zip(parts, Ts_bin_part, strict=True))
        if all(_is_inside(part.mesh.points, T, bin) for part, T in fallen):
            return tuple(Detection(part.name, bin.T_world_bin * T) for part, T in fallen)
    raise InputError(f"{what} did not stay in the bin in {ATTEMPTS} attempts; take fewer")


def _radius(part: Part) -> float:
    """Of the ball about the part's frame that holds it [m]."""
    return float(np.linalg.norm(part.mesh.points, axis=1).max())


def _volume(part: Part) -> float:
    """Of the part [m3], by the divergence theorem."""
    a, b, c = part.mesh.points[part.mesh.triangles.T]
    return abs(float(np.einsum("ni,ni->", a, np.cross(b, c)))) / 6


def _model(parts: Sequence[Part], bin: Bin) -> mujoco.MjModel:
    """Bin and parts as MuJoCo sees them; the world frame is that of the bin."""
    spec = mujoco.MjSpec()
    spec.option.timestep = TIMESTEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    for solid in bin.solids:
        _add_geom(spec, spec.worldbody, solid)
    for number, part in enumerate(parts):
        body = spec.worldbody.add_body(name=str(number), gravcomp=1.0)  # until it is dropped
        body.add_freejoint()
        for solid in part.pieces:
            _add_geom(spec, body, solid)
    model = spec.compile()
    # Pieces may overlap, so their volumes tell how the mass is spread but not how much it is.
    masses = np.array([part.mass for part in parts])
    model.body_inertia[1:] *= (masses / model.body_mass[1:])[:, None]
    model.body_mass[1:] = masses
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def _add_geom(spec: mujoco.MjSpec, body: mujoco.MjsBody, solid: Solid) -> None:
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
            surface = surface_of(solid.shape)
            spec.add_mesh(
                name=name,
                uservert=np.asarray(surface.vertices, dtype=np.float32).ravel(),
                userface=np.asarray(surface.faces, dtype=np.int32).ravel(),
            )
            geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, name


def _starts(
    bin: Bin, count: int, radius: float, generator: np.random.Generator
) -> list[tuple[Floats, Floats]]:
    """Place over the bin (2,) [m] and attitude (quaternion w x y z) of each part.

    The bin is divided into cells, one at least for each part, so that the parts spread.
    """
    room = np.maximum(bin.size[:2] / 2 - radius, 0.0)
    columns = max(1, round(np.sqrt(count * bin.size[0] / bin.size[1])))
    cells = np.array([columns, -(-count // columns)])
    chosen = generator.permutation(cells.prod())[:count]
    corner = np.stack(np.unravel_index(chosen, cells), axis=1)
    places = ((corner + generator.random((count, 2))) / cells * 2 - 1) * room
    attitudes = generator.standard_normal((count, 4))
    attitudes /= np.linalg.norm(attitudes, axis=1, keepdims=True)
    return list(zip(places, attitudes, strict=True))


def _settle(
    model: mujoco.MjModel, starts: list[tuple[Floats, Floats]], radius: float
) -> list[pin.SE3]:
    """Let the parts fall one after another; T_bin_part when all lie still."""
    data = mujoco.MjData(model)
    model.body_gravcomp[1:] = 1.0
    state = data.qpos.reshape(len(starts), 7)
    for number in range(len(starts)):  # waiting, weightless, far above each other
        state[number, :3] = (0.0, 0.0, 10.0 + 3.0 * radius * number)
    for number, (place, attitude) in enumerate(starts):
        top = state[:number, 2].max(initial=0.0)
        state[number, :2] = place
        state[number, 2] = top + (2.1 if number else 1.1) * radius
        state[number, 3:] = attitude
        data.qvel[6 * number : 6 * number + 6] = 0.0
        model.body_gravcomp[number + 1] = 0.0
        mujoco.mj_step(model, data, nstep=round(BETWEEN_DROPS / TIMESTEP))
    speed = data.qvel.reshape(len(starts), 6)
    for _ in range(round(LONGEST / TIMESTEP / 25)):
        mujoco.mj_step(model, data, nstep=25)
        turning = np.abs(speed[:, 3:]).max() * radius
        if max(np.abs(speed[:, :3]).max(), turning) < AT_REST:
            break
    return [
        pin.SE3(pin.Quaternion(w, x, y, z).normalized().matrix(), position.copy())
        for *position, w, x, y, z in state
        for position in [np.array(position)]
    ]


def _is_inside(points: Floats, T_bin_part: pin.SE3, bin: Bin) -> bool:
    """Whether all of the part's points are between the walls and above the floor."""
    p_bin = points @ T_bin_part.rotation.T + T_bin_part.translation
    across = np.abs(p_bin[:, :2]).max(axis=0)
    return bool(np.all(across <= bin.size[:2] / 2 + OUTSIDE) and p_bin[:, 2].min() >= -OUTSIDE)

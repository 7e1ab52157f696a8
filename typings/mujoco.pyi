"""Types for what the workbench uses of MuJoCo, which comes without any.

Angles in rad, lengths in m.
"""

from collections.abc import Sequence
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

class mjtGeom(Enum):
    mjGEOM_SPHERE = ...
    mjGEOM_CAPSULE = ...
    mjGEOM_CYLINDER = ...
    mjGEOM_BOX = ...
    mjGEOM_MESH = ...

class mjtIntegrator(Enum):
    mjINT_IMPLICITFAST = ...

class mjtCone(Enum):
    mjCONE_ELLIPTIC = ...

class _Option:
    timestep: float
    integrator: mjtIntegrator
    cone: mjtCone
    noslip_iterations: int

class MjsGeom:
    type: mjtGeom
    size: ArrayLike
    meshname: str

class MjsBody:
    def add_body(self, *, name: str = ..., gravcomp: float = ..., mocap: bool = ...) -> MjsBody: ...
    def add_freejoint(self) -> object: ...
    def add_geom(
        self,
        *,
        pos: ArrayLike = ...,
        quat: ArrayLike = ...,
        friction: ArrayLike = ...,
        condim: int = ...,
        solref: ArrayLike = ...,
        solimp: ArrayLike = ...,
    ) -> MjsGeom: ...

class MjSpec:
    option: _Option
    worldbody: MjsBody
    meshes: Sequence[object]
    def add_mesh(
        self, *, name: str, uservert: NDArray[np.float32], userface: NDArray[np.int32]
    ) -> object: ...
    def compile(self) -> MjModel: ...

class MjModel:
    body_mass: NDArray[np.float64]
    body_inertia: NDArray[np.float64]
    body_gravcomp: NDArray[np.float64]

class MjData:
    qpos: NDArray[np.float64]
    qvel: NDArray[np.float64]
    mocap_pos: NDArray[np.float64]
    mocap_quat: NDArray[np.float64]
    def __init__(self, model: MjModel, /) -> None: ...

def mj_setConst(m: MjModel, d: MjData) -> None: ...
def mj_step(m: MjModel, d: MjData, nstep: int = ...) -> None: ...

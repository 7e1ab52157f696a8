"""Types for what the workbench uses of MuJoCo, which comes without any.

Angles in rad, lengths in m.
"""

from collections.abc import Mapping, Sequence
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

class mjtGeom(Enum):
    mjGEOM_PLANE = ...
    mjGEOM_SPHERE = ...
    mjGEOM_CAPSULE = ...
    mjGEOM_CYLINDER = ...
    mjGEOM_BOX = ...
    mjGEOM_MESH = ...

class mjtJoint(Enum):
    mjJNT_SLIDE = ...

class mjtTrn(Enum):
    mjTRN_JOINT = ...

class mjtGain(Enum):
    mjGAIN_FIXED = ...

class mjtBias(Enum):
    mjBIAS_AFFINE = ...

class mjtEq(Enum):
    mjEQ_JOINT = ...

class mjtIntegrator(Enum):
    mjINT_IMPLICITFAST = ...

class mjtCone(Enum):
    mjCONE_ELLIPTIC = ...

class mjtWarning(Enum):
    mjWARN_CONTACTFULL = ...
    mjWARN_CNSTRFULL = ...

class FatalError(Exception): ...

class _Option:
    timestep: float
    integrator: mjtIntegrator
    cone: mjtCone
    noslip_iterations: int
    impratio: float
    gravity: NDArray[np.float64]

class MjsGeom:
    type: mjtGeom
    size: ArrayLike
    meshname: str
    contype: int
    conaffinity: int
    condim: int
    friction: ArrayLike
    solref: ArrayLike
    solimp: ArrayLike

class MjsBody:
    mass: float
    inertia: ArrayLike
    gravcomp: float
    explicitinertial: bool
    def add_body(self, *, name: str = ..., gravcomp: float = ..., mocap: bool = ...) -> MjsBody: ...
    def add_freejoint(self) -> object: ...
    def add_joint(self, *, name: str, type: mjtJoint, axis: ArrayLike) -> object: ...
    def add_geom(
        self,
        *,
        name: str = ...,
        type: mjtGeom = ...,
        size: ArrayLike = ...,
        pos: ArrayLike = ...,
        quat: ArrayLike = ...,
        friction: ArrayLike = ...,
        condim: int = ...,
        solref: ArrayLike = ...,
        solimp: ArrayLike = ...,
    ) -> MjsGeom: ...

class MjSpec:
    memory: int
    option: _Option
    worldbody: MjsBody
    meshes: Sequence[object]
    def add_mesh(
        self, *, name: str, uservert: NDArray[np.float32], userface: NDArray[np.int32]
    ) -> object: ...
    def add_equality(
        self,
        *,
        type: mjtEq,
        name1: str,
        name2: str,
        data: Sequence[float],
        solref: ArrayLike,
    ) -> object: ...
    def add_actuator(
        self,
        *,
        name: str,
        target: str,
        trntype: mjtTrn,
        gaintype: mjtGain,
        biastype: mjtBias,
        gainprm: Sequence[float],
        biasprm: Sequence[float],
        forcerange: Sequence[float],
        forcelimited: bool,
    ) -> object: ...
    def compile(self) -> MjModel: ...

class _Named:
    id: int

class _Contacts:
    geom: NDArray[np.int32]

class _Warning:
    number: int

class MjModel:
    opt: _Option
    body_pos: NDArray[np.float64]
    body_quat: NDArray[np.float64]
    body_ipos: NDArray[np.float64]
    dof_damping: NDArray[np.float64]
    jnt_stiffness: NDArray[np.float64]
    geom_bodyid: NDArray[np.int32]
    geom_contype: NDArray[np.int32]
    def body(self, name: str, /) -> _Named: ...
    def geom(self, name: str, /) -> _Named: ...
    body_mass: NDArray[np.float64]
    body_inertia: NDArray[np.float64]
    body_gravcomp: NDArray[np.float64]

class MjData:
    contact: _Contacts
    warning: Mapping[mjtWarning, _Warning]
    qfrc_applied: NDArray[np.float64]
    xfrc_applied: NDArray[np.float64]
    xipos: NDArray[np.float64]
    qpos: NDArray[np.float64]
    qvel: NDArray[np.float64]
    ctrl: NDArray[np.float64]
    mocap_pos: NDArray[np.float64]
    mocap_quat: NDArray[np.float64]
    def __init__(self, model: MjModel, /) -> None: ...

def mj_forward(m: MjModel, d: MjData) -> None: ...
def mj_setConst(m: MjModel, d: MjData) -> None: ...
def mj_step(m: MjModel, d: MjData, nstep: int = ...) -> None: ...

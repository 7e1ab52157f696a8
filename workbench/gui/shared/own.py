"""What one browser alone looks at: a robot moved by hand, a posed one, a film, a distance."""

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import pinocchio as pin

from workbench.app.core.state import State
from workbench.app.emptying.film import Film
from workbench.app.picking.glance import Glance
from workbench.model.calibration import BallPlate
from workbench.model.geometry import Floats
from workbench.model.plan import Plan
from workbench.model.scan import Detection
from workbench.proof.claims.spot import Spot


@dataclass(frozen=True, slots=True, eq=False)
class Visited:
    """Where a plan comes nearest to something: at `time` [s] on its clock, with what to say."""

    plan: Plan
    time: float
    spot: Spot
    says: str


@dataclass(frozen=True, slots=True, eq=False)
class Showing:
    """A film of an emptied pile that somebody looks at, at `time` [s] on its clock.

    It is `seconds` long, and `speed` is how many times as fast as planned it plays; `kinds` says by
    number why a part stays in the bin, `chosen` is the number of the one that is viewed.
    """

    film: Film
    seconds: float
    kinds: Mapping[int, str]
    time: float = 0.0
    is_playing: bool = True
    speed: float = 1.0
    chosen: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Dragged:
    """How candidates would be judged where something is dragged just now.

    The words stand at `T_world_words`; all else is as in `state`.
    """

    glance: Glance
    T_world_words: pin.SE3
    state: State


@dataclass(frozen=True, slots=True, eq=False)
class Carried:
    """What of the scene follows a gizmo that is dragged: nodes by name, with their poses.

    A pose is in what the node is below of; all else is as in `state`.
    """

    Ts_node: Mapping[str, pin.SE3]
    state: State


@dataclass(frozen=True, slots=True, eq=False)
class ShownPlate:
    """The plate of a suggested pose: how `arm` is assumed to hold it, or where it stands.

    `T_flange_plate` is meant as `Calibration` means it.
    """

    arm: str
    plate: BallPlate
    T_flange_plate: pin.SE3


@dataclass(frozen=True, slots=True, eq=False)
class Own:
    """What somebody does in their own view; nobody else sees anything of it.

    `jog` holds the arms that are moved by hand, arm -> configuration (n,) [rad]; `plate` is drawn
    with them after a suggestion, until jogging ends; `observation` is the pose of a calibration
    that is laid over the robot, `is_calibrated` says with which pose of the scanner; `film` is what
    is shown of an emptied pile; `measured` are the points (3,) [m] that were clicked on, up to two;
    `visited` is the place of the plan that is viewed; `dragged` is what is shown of the candidates
    while something is dragged, `carried` what of the scene follows the hand that drags; `thing` is
    what of the cell was chosen to be moved, empty where a candidate was chosen since; `part` is the
    part found that was chosen, `pointed` the one that was clicked on in the scene last.
    """

    jog: Mapping[str, Floats] | None = None
    plate: ShownPlate | None = None
    observation: int | None = None
    is_calibrated: bool = True
    film: Showing | None = None
    measured: tuple[Floats, ...] = ()
    visited: Visited | None = None
    dragged: Dragged | None = None
    carried: Carried | None = None
    thing: str = ""
    part: Detection | None = None
    pointed: Detection | None = None

    @property
    def hides_robot(self) -> bool:
        """Whether the robot stands elsewhere here than for everybody else."""
        return self.jog is not None or self.observation is not None or self.film is not None


NOTHING_OWN = Own()


class OwnLook:
    """The own look of one browser.

    Lifetime: that of the browser's controls; what was viewed ends with them.

    Concurrency: any thread; `changed` is called after each change, outside the lock.
    """

    def __init__(self, changed: Callable[[], None]):
        """What everybody sees, and nothing besides."""
        self._now = NOTHING_OWN
        self._lock = threading.Lock()
        self._changed = changed

    @property
    def now(self) -> Own:
        """The newest look."""
        return self._now

    def change(self, **fields: Any) -> None:
        """Replace fields of the look; a robot that is moved by hand, or posed, is in no film."""
        if fields.get("jog") is not None or fields.get("observation") is not None:
            fields = {**fields, "film": None}
        if "jog" in fields and fields["jog"] is None:
            fields = {**fields, "plate": None}
        with self._lock:
            self._now = replace(self._now, **fields)
        self._changed()

    def show(self, changed: Callable[[Showing], Showing]) -> None:
        """Go on with the film that is viewed, if one is, as `changed` makes it of how it was."""
        with self._lock:
            if self._now.film is None:
                return
            film = changed(self._now.film)
            if film is self._now.film:
                return
            self._now = replace(self._now, film=film)
        self._changed()

    def end(self) -> None:
        """See the robot again where everybody sees it."""
        if self._now.hides_robot:
            self.change(jog=None, observation=None, film=None)

    def let_go(self) -> None:
        """Move no robot, as only those may who are not mere followers; a film goes on."""
        if self._now.jog is not None or self._now.observation is not None:
            self.change(jog=None, observation=None)

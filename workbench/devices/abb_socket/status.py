"""How a connection for motion stands, for looking at."""

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.model.geometry import Floats


@dataclass(frozen=True, slots=True, eq=False)
class LinkStatus:
    """How the link stands, for looking at; times [s since the epoch].

    `phase` is what the controller says of itself, or `closed`; `acknowledged` its last
    acknowledgement; `stopped` how long [s] it took to acknowledge a stop, None when it did not, and
    `stop` says so in words.  `joints` (arm -> (n,) [rad]) are the last it reported on this link.
    """

    version: str = ""
    phase: str = "closed"
    step: int = 0
    steps: int = 0
    acknowledged: str = ""
    acknowledged_at: float = 0.0
    reported_at: float = 0.0
    stopped: float | None = None
    stop: str = ""
    joints: Mapping[str, Floats] | None = None

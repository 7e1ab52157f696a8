"""What goes on at this moment: for looking at, never recorded, and it decides nothing."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True, eq=False)
class Live:
    """Progress of the running job, and the robot as it stands now.

    `job` is the number of the job that `done` (0..1), `note` and `started` [s since the epoch]
    belong to, 0 before the first.  `joints` (name -> rad) is what the controller reported
    last, `robot` its own word for what it does; both are empty while it reports nothing.
    """

    job: int = 0
    done: float = 0.0
    note: str = ""
    started: float = 0.0
    joints: Mapping[str, float] = field(default_factory=dict[str, float])
    robot: str = ""

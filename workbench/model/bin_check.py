"""What a scan says about the bin itself: where it is, and how full."""

from dataclasses import dataclass

import pinocchio as pin

from workbench.model.calibration import Light
from workbench.model.geometry import copied, put


@dataclass(frozen=True, slots=True, eq=False)
class BinCheck:
    """The bin as a scan shows it.

    `T_world_bin` is where its rim is seen, None when it is not; `shift` [m] and `turn` [rad] by how
    much that differs from the cell.  `fill` 0..1 is the share of its room that is taken as seen
    from above, None when the inside is not seen; `above` [m] how far something sticks out of it.
    `findings` say in words what is not as it should be, the worst first.
    """

    T_world_bin: pin.SE3 | None
    shift: float
    turn: float
    fill: float | None
    above: float
    light: Light
    findings: tuple[str, ...]
    is_elsewhere: bool = False
    is_empty: bool = False
    is_overfull: bool = False

    def __post_init__(self) -> None:
        if self.T_world_bin is not None:
            put(self, T_world_bin=copied(self.T_world_bin))

    @property
    def says(self) -> str:
        """All of it in one sentence."""
        full = "" if self.fill is None or self.is_empty else f", {self.fill:.0%} full"
        if not self.findings:
            return f"the bin is where it should be, to {self.shift * 1000:.1f} mm{full}"
        return "; ".join(self.findings) + full

"""Whether a tool can take a part as a grasp says: the part alone, before any cell or robot."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin

from workbench.model.cell import Tool
from workbench.model.derived.by_tcp import is_for, may_touch
from workbench.model.messages.grasps import GripText
from workbench.model.messages.message import Message
from workbench.model.part import Grasp, Part, widen_grasp
from workbench.planning.collision.distances.measuring import Group, group_distance
from workbench.planning.collision.hands import closed_press
from workbench.planning.grasps.cup import Cup
from workbench.planning.grasps.firmness import (
    Firmness,
    cup_contacts,
    finger_contacts,
    firmness,
    in_words,
)
from workbench.planning.grasps.pads import PadContact, Pads, has_pads
from workbench.planning.grasps.part_rays import centre_of_mass

FindingKind = Literal[
    "tool", "stroke", "cut", "approach", "width", "contact", "slip", "seal", "weight"
]

FRICTION = np.arctan(0.4)
"""[rad] Half the angle of the friction cone: rubber pads on metal or plastic."""

ROUNDING = 1e-5
"""[m] What cuts no deeper touches."""

CHECK_SPACING = 0.002
"""[m] Along the approach."""

LEAST_AREA = 10e-6
"""[m2] A pad that touches less holds an edge or a corner."""

MOST_UNSEALED = 0.02
"""Share of a cup's lip that may lie beyond the part, by rounding of the grid."""


@dataclass(frozen=True, slots=True)
class GraspFinding:
    """A problem of a grasp, or a remark if `is_problem` is False.

    `amount` is the size of the problem [m]; for `slip` [rad].  For a cup's lip it is a share of the
    lip, for `weight` the share of the load that is held.
    """

    kind: FindingKind
    text: Message
    amount: float
    is_problem: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class GraspCheck:
    """What was found about a grasp with a tool.

    `width` [m] of the part between the fingers, None for cups and where nothing is; `clearance`
    [m] of the open tool to the part on arrival, below 0 when it cuts; `hold` how the pads lie;
    `firmness` how well it holds the part's weight, None where that was not asked or not stated.
    """

    grasp: str
    tool: str
    findings: tuple[GraspFinding, ...]
    width: float | None
    clearance: float
    hold: PadContact | None = None
    firmness: Firmness | None = None

    @property
    def is_ok(self) -> bool:
        """Whether nothing speaks against the grasp."""
        return not any(finding.is_problem for finding in self.findings)


class GraspChecker:
    """Checks any number of grasps of a part by a tool.

    Holding forces are checked if the cell states the tool's force and the part's friction.  They
    must hold the weight and an `acceleration` [m/s2] in any direction; None skips the check.

    Lifetime: as long as part and tool.
    Concurrency: one thread at a time.
    """

    def __init__(self, part: Part, tool: Tool, acceleration: float | None = None):
        self.part = part
        self.tool = tool
        self._acceleration = acceleration
        self._centre = centre_of_mass(part.mesh)
        self.pads = Pads(tool) if has_pads(tool) else None
        self.cup = None if tool.fingers or not tool.body else Cup(tool)
        T_tcp_flange = tool.T_flange_tcp.inverse()
        moving = [(finger.solid, np.asarray(finger.direction) / 2) for finger in tool.fingers]
        solids = [*((solid, np.zeros(3)) for solid in tool.body), *moving]
        self._names = [solid.name for solid, _ in solids]
        # How each goes for a metre of opening, in the TCP frame.
        self._travels = np.array([T_tcp_flange.rotation @ travel for _, travel in solids]).reshape(
            -1, 3
        )
        self._tool_group = Group([(s.shape, T_tcp_flange * s.T_owner_shape) for s, _ in solids])
        barred = [solid for solid in tool.body if not may_touch(tool, solid.name)]
        self._barred_names = [solid.name for solid in barred]
        self._barred_group = Group([(s.shape, T_tcp_flange * s.T_owner_shape) for s in barred])
        self._part_group = Group([(piece.shape, piece.T_owner_shape) for piece in part.pieces])

    def clearance(
        self, T_part_tcp: pin.SE3, opening: float, within: float = np.inf
    ) -> tuple[float, str]:
        """How far the tool is from the part [m], below 0 how deep it cuts, and the solid nearest.

        Distances beyond `within` are not distinguished.
        """
        shifts = self._travels * opening
        best, at = group_distance(self._tool_group, T_part_tcp, shifts, self._part_group, within)
        return best, self._names[at] if at >= 0 else ""

    def way_in(self, grasp: Grasp) -> tuple[float, float, str]:
        """The least distance on the linear motion in, open.

        Returns:
            The distance [m], how far before the end of the way [m], and the solid; the distance is
            not below `-ROUNDING` when the way is clear.
        """
        worst, where, at = np.inf, 0.0, ""
        gone = 0.0
        while gone <= grasp.approach_length:
            back = grasp.T_part_tcp.rotation @ (grasp.approach * gone)
            T = pin.SE3(grasp.T_part_tcp.rotation, grasp.T_part_tcp.translation - back)
            distance, name = self.clearance(T, grasp.opening)
            if distance < worst:
                worst, where, at = distance, gone, name
            gone += max(distance, CHECK_SPACING)
        return worst, where, at

    def hold(self, T_part_tcp: pin.SE3, opening: float | None = None) -> PadContact | None:
        """What two fingers close on from `opening`, from the widest when not given."""
        if self.pads is None:
            return None
        wide = self.tool.stroke[1] if opening is None else opening
        return self.pads.hold(self.part.mesh, T_part_tcp.inverse(), wide)

    def check(self, grasp: Grasp) -> GraspCheck:
        """Everything that can be said about an authored grasp without a cell."""
        grasp = widen_grasp(grasp, self.part.tolerance)
        findings: list[GraspFinding] = []
        if grasp.tool and grasp.tool != self.tool.name:
            text = GripText.OTHER_TOOL(wanted=grasp.tool, tool=self.tool.name)
            findings.append(GraspFinding("tool", text, 0.0, is_problem=False))
        elif not is_for(grasp, self.tool):
            text = GripText.OTHER_TCP(wanted=grasp.tcp, tool=self.tool.name)
            findings.append(GraspFinding("tool", text, 0.0, is_problem=False))
        hold = None
        if self.tool.fingers:
            findings += _stroke_findings(grasp, self.tool)
            clearance = self._cuts(grasp, findings)
            if self.pads is not None:
                hold = self.hold(grasp.T_part_tcp, max(grasp.opening, 0.0))
                findings += _hold_findings(grasp, self.tool, hold)
        else:
            clearance = self._cuts(grasp, findings)
            findings += self.seal_findings(grasp)
        width = None if hold is None else hold.width
        firm = None
        if not any(finding.is_problem for finding in findings):
            firm = self.firmness(grasp.T_part_tcp, grasp.opening)
        if firm is not None and not firm.is_enough:
            findings.append(GraspFinding("weight", in_words(firm), firm.share))
        return GraspCheck(grasp.name, self.tool.name, tuple(findings), width, clearance, hold, firm)

    def firmness(self, T_part_tcp: pin.SE3, opening: float) -> Firmness | None:
        """How well a grip holds the part's weight; None where too little is stated to say it.

        Also where nothing is between the fingers.
        """
        force, friction = self.tool.force, self.part.friction
        if self._acceleration is None or force is None or friction is None:
            return None
        if self.pads is not None:
            hold = self.hold(T_part_tcp, opening)
            if hold is None:
                return None
            contacts = finger_contacts(hold, self.pads.travel, force, friction)
        elif self.cup is not None:
            contacts = cup_contacts(self.cup, force, friction)
        else:
            return None
        centre = T_part_tcp.actInv(self._centre)
        return firmness(contacts, centre, self.part.mass, self._acceleration)

    def _cuts(self, grasp: Grasp, findings: list[GraspFinding]) -> float:
        """Where the tool cuts the part: arriving, on the way, closed; the clearance on arrival."""
        press = closed_press(self.tool, self.part)
        allowed = ROUNDING if self.tool.fingers else press
        has_fingers, opening = bool(self.tool.fingers), grasp.opening
        clearance, at = self.clearance(grasp.T_part_tcp, grasp.opening)
        if clearance < -allowed:
            text = GripText.CUTS(solid=at, depth=-clearance)
            if has_fingers:
                text = GripText.CUTS_AT(solid=at, depth=-clearance, opening=opening)
            findings.append(GraspFinding("cut", text, -clearance))
        worst, where, at = self.way_in(grasp)
        if worst < -allowed and worst < clearance - ROUNDING:
            cut = {"solid": at, "depth": -worst, "before": where}
            text = GripText.CUTS_ON_WAY(**cut)
            if has_fingers:
                text = GripText.CUTS_ON_WAY_AT(**cut, opening=opening)
            findings.append(GraspFinding("approach", text, -worst))
        if self._barred_names and (cut := self._barred_cut(grasp.T_part_tcp)):
            findings.append(GraspFinding("cut", GripText.CUTS(solid=cut[1], depth=cut[0]), cut[0]))
        if self.tool.fingers:
            closed, at = self.clearance(grasp.T_part_tcp, grasp.grip, within=0.0)
            if closed < -press - ROUNDING:
                text = GripText.CUTS_CLOSED(grip=grasp.grip, solid=at, depth=-closed, press=press)
                findings.append(GraspFinding("cut", text, -closed))
        return clearance

    def _barred_cut(self, T_part_tcp: pin.SE3) -> tuple[float, str] | None:
        """How deep [m] a solid cuts the part that may not touch it, and which; None for none."""
        still = np.zeros((len(self._barred_names), 3))
        far, at = group_distance(self._barred_group, T_part_tcp, still, self._part_group, 0.0)
        return (-far, self._barred_names[at]) if far < -ROUNDING and at >= 0 else None

    def seal_findings(self, grasp: Grasp) -> list[GraspFinding]:
        """What keeps the lip of a cup from closing; nothing for another tool."""
        cup = self.cup
        if cup is None:
            return []
        seal = cup.seal(self.part.mesh, grasp.T_part_tcp.inverse(), grasp.approach_length)
        press, across = self.tool.press, 2 * cup.radius
        if seal is None:
            return [GraspFinding("seal", GripText.NOTHING_UNDER_CUP(), 1.0)]
        found: list[GraspFinding] = []
        if seal.missing > MOST_UNSEALED:
            text = GripText.LIP_BEYOND(share=seal.missing, across=across)
            found.append(GraspFinding("seal", text, seal.missing))
        if seal.unevenness > press:
            text = GripText.UNEVEN(uneven=seal.unevenness, press=press)
            found.append(GraspFinding("seal", text, seal.unevenness))
        elif seal.height < -press:
            text = GripText.CUP_SHORT(gap=-seal.height)
            found.append(GraspFinding("seal", text, -seal.height))
        return found


def _stroke_findings(grasp: Grasp, tool: Tool) -> list[GraspFinding]:
    low, high = tool.stroke
    found: list[GraspFinding] = []
    for name, value in ((GripText.OPENING, grasp.opening), (GripText.GRIP, grasp.grip)):
        beyond = max(value - high, low - value)
        if beyond > ROUNDING:
            text = name(value=value, low=low, high=high)
            found.append(GraspFinding("stroke", text, beyond))
    return found


def _hold_findings(grasp: Grasp, tool: Tool, hold: PadContact | None) -> list[GraspFinding]:
    """Whether both pads lie on the part as the grasp says."""
    if hold is None:
        return [GraspFinding("contact", GripText.NOTHING_BETWEEN(), 0.0)]
    found: list[GraspFinding] = []
    apart = grasp.grip - hold.width
    if abs(apart) > tool.press:
        text = GripText.WIDTH(width=hold.width, grip=grasp.grip)
        found.append(GraspFinding("width", text, abs(apart)))
    names = [finger.solid.name for finger in tool.fingers]
    for name, slant, area in zip(names, hold.slants, hold.areas, strict=True):
        if slant > FRICTION:
            text = GripText.INCLINED(finger=name, angle=slant)
            found.append(GraspFinding("slip", text, slant))
        if area < LEAST_AREA:
            text = GripText.SMALL_AREA(finger=name, area=f"{area * 1e6:.1f}")
            found.append(GraspFinding("contact", text, area, is_problem=False))
    if abs(hold.offset) > tool.press:
        first = names[0] if hold.offset > 0 else names[1]
        text = GripText.OFF_CENTRE(aside=abs(hold.offset), finger=first)
        found.append(GraspFinding("contact", text, abs(hold.offset), is_problem=False))
    return found

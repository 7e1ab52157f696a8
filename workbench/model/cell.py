"""The cell: robot, arms with their tools, bin, fixtures, scanner, controller, and its policies."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Literal, get_args

import numpy as np
import pinocchio as pin

from workbench.model.calibration import CalibrationRecord
from workbench.model.digest import LATER, FactsRepr, called, digest_of
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, Solid, copy_pose, own, put
from workbench.model.messages.cells import CellText
from workbench.model.motion import MotionModel
from workbench.model.part import Bin, Part, PartPlace, Station
from workbench.model.recipes.recipe import NO_RECIPE, Recipe
from workbench.model.robot import ArmScanner, AxisMapping, Robot, Tcp, ToolSlot
from workbench.model.scan import LocalizerChoice, Option, PosesFolder

OrderName = Literal["travel", "highest", "score", "nearest", "walls", "thesis"]
ORDER_NAMES: tuple[OrderName, ...] = get_args(OrderName)

LiftName = Literal["leaning", "up", "back", "off-wall", "around", "any"]
LIFT_NAMES: tuple[LiftName, ...] = get_args(LiftName)


@dataclass(frozen=True, slots=True, eq=False)
class Finger:
    """A finger: its solid when closed, in the flange frame, and where it moves as it opens.

    `direction` (3,) is a unit vector.  Two fingers share the opening: each moves half of it.
    """

    solid: Solid
    direction: Floats

    def __post_init__(self) -> None:
        own(self, "direction")


@dataclass(frozen=True, slots=True, eq=False)
class Tool:
    """A gripper on the flange; solids in the flange frame; `stroke` (min, max) opening [m].

    `press` [m] is its compliance at the part: that of finger pads, or of the lip of a suction cup.
    `force` [N] is the closing force of each finger, or the force of the vacuum; None: unknown.
    `mass` [kg] may be None, too.  `centre_of_gravity` (3,) [m] and `inertia` (3, 3) [kg m2] about
    it are None if they are to be estimated (`model.load`).
    `T_flange_tcp` is the pose of `tcp`, one of `tcps`, the first unless a plan states another.
    """

    name: str
    T_flange_tcp: pin.SE3
    body: tuple[Solid, ...]
    fingers: tuple[Finger, ...] = ()
    stroke: tuple[float, float] = (0.0, 0.0)
    press: float = 0.0015
    force: float | None = field(default=None, metadata=LATER)
    mass: float | None = field(default=None, metadata=LATER)
    centre_of_gravity: Floats | None = field(default=None, metadata=LATER)
    inertia: Floats | None = field(default=None, metadata=LATER)
    tcps: tuple[Tcp, ...] = field(default=(), metadata=LATER)
    tcp: str = field(default="", metadata=LATER)

    def __post_init__(self) -> None:
        own(self, "T_flange_tcp", "centre_of_gravity", "inertia")

    @property
    def reach(self) -> float:
        """How far [m] its farthest point gets from the flange, at most."""
        fingers = [finger.solid.reach + self.stroke[1] / 2 for finger in self.fingers]
        return max([*(solid.reach for solid in self.body), *fingers], default=0.0)


MOST_PICKS = 10
"""Plans in a row after one scan."""

ARM_NAME = r"[A-Za-z0-9_][A-Za-z0-9_-]{0,39}"
"""What an arm can be called."""


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """One kinematic chain with a tool.

    `name` matches `ARM_NAME` and is no word of a strategy; the controller's is `controller_id`.
    `joints` are the movable joints from base to flange (chain order).  `axis_order[k]` is the index
    in the chain of the controller's k-th axis, `axis_signs` its sense; see also `mapping`.  `home`
    (n,) [rad], `acceleration` (n,) [rad/s2] and `jerk` (n,) [rad/s3] are in chain order; without
    `jerk` the acceleration may jump.  `moving_mass` [kg] is that of all moving links.
    `part_places` state target poses of parts; `Ts_world_place`, with `place_names`, are TCP poses
    at the release.  They are tried in this order, those at one position by time.  Parts stay
    (`keeps_parts`) or are gone before the next (`passes_parts_on`).  `needs_roll` excludes parts of
    unknown roll.  `tool` is the mounted one of `tools`, `tool_slots` hold the others.
    """

    name: str
    controller_id: str = field(metadata=called("letter"))
    flange: str
    joints: tuple[str, ...]
    axis_order: tuple[int, ...] = field(metadata=called("wire_order"))
    axis_signs: tuple[int, ...] = field(metadata=called("wire_signs"))
    home: Floats
    acceleration: Floats
    tool: Tool
    Ts_world_place: tuple[pin.SE3, ...] = ()
    keeps_parts: bool = False
    tools: tuple[Tool, ...] = ()
    needs_roll: bool = field(default=False, metadata=LATER)
    part_places: tuple[PartPlace, ...] = field(default=(), metadata=LATER)
    passes_parts_on: bool = field(default=False, metadata=LATER)
    jerk: Floats | None = field(default=None, metadata=LATER)
    place_names: tuple[str, ...] = field(default=(), metadata=LATER)
    mapping: AxisMapping | None = field(default=None, metadata=LATER)
    moving_mass: float | None = field(default=None, metadata=LATER)
    tool_slots: tuple[ToolSlot, ...] = field(default=(), metadata=LATER)

    def __post_init__(self) -> None:
        own(self, "home", "acceleration", "jerk")
        put(
            self,
            Ts_world_place=tuple(copy_pose(T) for T in self.Ts_world_place),
            part_places=tuple(self.part_places),
        )

    def places_for(self, part: str) -> tuple[PartPlace, ...]:
        """The places where parts of that kind have to lie, in the order in which they are tried."""
        return tuple(place for place in self.part_places if place.is_for(part))

    def to_axes(self, q: Floats) -> Floats:
        """A configuration (n,) [rad], chain order, as the controller counts its axes."""
        return np.asarray(q)[list(self.axis_order)] * np.array(self.axis_signs)

    def from_axes(self, axes: Floats) -> Floats:
        """The configuration (n,) [rad], chain order, of axes as the controller counts them."""
        q = np.empty(len(self.joints))
        q[list(self.axis_order)] = np.asarray(axes) * np.array(self.axis_signs)
        return q


@dataclass(frozen=True, slots=True, eq=False)
class Fixture:
    """Something that stands still: table, tray, fence."""

    name: str
    T_world_fixture: pin.SE3
    solids: tuple[Solid, ...]

    def __post_init__(self) -> None:
        own(self, "T_world_fixture")


Z_FORWARD, IN_WORLD = "z_forward", "world"
"""Axes of a cloud: the scanner's, x right and y down; or the cell's, from the cell's origin."""


@dataclass(frozen=True, slots=True, eq=False)
class ScannerMount:
    """Pose and properties of the scanner: camera frame z forward, x right, y down.

    `resolution` is (columns, rows), `field_of_view` [rad] the angle along the columns.
    `depth_noise` [m] is the standard deviation of a simulated pixel at 1 m, before averaging.
    `near` and `far` [m] limit its range.  `source` names the driver (`plugins.scanner`), `address`
    is in the driver's form, `options` are its keys.  `patience` [s] is the timeout of a scan.
    `unit` and `cloud_axes` (`formats.clouds.scans.CLOUD_AXES`) are those of files.  `calibration`
    states who measured the pose and when; after `calibration_days` it counts as old.
    `while_moving`: scans are possible while arms move outside the view.  `on_arm` is the arm that
    carries the scanner; then `T_world_scanner` is its pose at the view.
    """

    T_world_scanner: pin.SE3
    resolution: tuple[int, int] = (640, 480)
    field_of_view: float = 0.8
    depth_noise: float = 0.0003
    near: float = 0.3
    far: float = 1.5
    source: str = "simulated"
    address: str = ""
    unit: str = "m"
    patience: float = 60.0
    calibration: CalibrationRecord | None = None
    calibration_days: float = 90.0
    options: Mapping[str, Option] = field(default_factory=dict[str, Option], metadata=LATER)
    cloud_axes: str = field(default=Z_FORWARD, metadata=LATER)
    while_moving: bool = field(default=False, metadata=LATER)
    on_arm: ArmScanner | None = field(default=None, metadata=LATER)

    def __post_init__(self) -> None:
        own(self, "T_world_scanner")
        put(self, options=dict(self.options))

    def housing_of(self, arm: str) -> tuple[Solid, ...]:
        """What an arm carries of the scanner, in its flange's frame; nothing where it stands."""
        return () if self.on_arm is None or self.on_arm.arm != arm else self.on_arm.housing


@dataclass(frozen=True, slots=True, eq=False)
class Controller:
    """Address of the robot controller, and its robot link.

    Motions are sent to `port`, reports come from `state_port`.  `options` are keys of the robot
    link that `motion` names.  `is_simulated`: this workbench has started it.
    """

    host: str
    port: int
    state_port: int
    motion: MotionModel
    options: Mapping[str, Option] = field(default_factory=dict[str, Option])
    is_simulated: bool = field(default=False, metadata=LATER)

    def __post_init__(self) -> None:
        put(self, options=dict(self.options))

    @property
    def link(self) -> str:
        """The name of the robot link."""
        return self.motion.link


@dataclass(frozen=True, slots=True)
class Policy:
    """The planning parameters of a cell; lengths [m], angles [rad].

    `margin` is that of free legs, `near_margin` that of the tool on linear legs, `self_margin` that
    between links of one arm.  `lift_length` and `lift_lean` shape the extraction: up, leaning to
    the bin centre.  `sink` is the largest penetration of a found part into its support; deeper is a
    wrong pose.  The part may slide along its support for `release` of its lift; then it keeps
    `near_margin`.  `speed` scales joint speeds.  `zone` is the largest corner rounding, as a
    fraction of the shorter neighbouring segment (`Cell.zone`).  `planner` (`plugins.planner`)
    searches the free legs, with `iterations` a call; `birrt` is the thesis' name for `rrtconnect`.
    `seconds` [s] limits the processor time of a planning.  `order` is the order of parts: by least
    time, height, score, distance to the tool, distance to the walls, or the thesis' rules
    (`planning.picking.order`). `metric` weighs the joints in the planners' distance: each counts
    this fraction of the one before it.  `lifts` (`planning.picking.lifts`) are tried in order for
    grasps without their own. `least_air` [m] is the least gap on each side of a part at which
    fingers may arrive less open than the grasp states; None: always as stated.  `pair_gap` [m]: of
    parts nearer to each other a plan takes only one; 0: no limit.  `picks` is the number of plans
    in a row after one scan. `tcp_speed`, `point_speed`, `held_speed` [m/s], `manual_speed`,
    `contact_energy` [J] are limits (`derived.speed_limits`), as are `stir_speed` and `slot_speed`.
    `as_needed`: whether `derived.policies.widened` may change grasps.  `stirs` limits the number of
    stirs in a row. `retry_without_scan`: whether a missed grip is followed by a plan from the same
    scan.
    """

    margin: float = 0.005
    near_margin: float = 0.001
    self_margin: float = 0.0
    lift_length: float = 0.1
    lift_lean: float = np.deg2rad(25.0)
    free_points: int = 10
    straight_points: int = 5
    speed: float = 0.5
    zone: float = 0.2
    threshold: float = 0.2
    planner: str = "rrtconnect"
    iterations: int = 500
    seconds: float = 60.0
    order: OrderName = "travel"
    metric: float = 0.6
    approval_minutes: float = 5.0
    lifts: tuple[LiftName, ...] = field(default=("leaning",), metadata=LATER)
    least_air: float | None = field(default=None, metadata=LATER)
    pair_gap: float = field(default=0.0, metadata=LATER)
    sink: float = field(default=0.001, metadata=LATER)
    release: float = field(default=0.01, metadata=LATER)
    picks: int = field(default=1, metadata=LATER)
    tcp_speed: float | None = field(default=None, metadata=LATER)
    point_speed: float | None = field(default=None, metadata=LATER)
    held_speed: float | None = field(default=None, metadata=LATER)
    manual_speed: bool = field(default=False, metadata=LATER)
    contact_energy: float | None = field(default=None, metadata=LATER)
    as_needed: bool = field(default=True, metadata=LATER)
    stirs: int = field(default=0, metadata=LATER)
    stir_speed: float = field(default=0.1, metadata=LATER)
    slot_speed: float = field(default=0.05, metadata=LATER)
    retry_without_scan: bool = field(default=False, metadata=LATER)


@dataclass(frozen=True, slots=True)
class PlanOverrides:
    """What one request changes of the cell's policy; None keeps the cell's value.

    A `margin` [m] below the cell's would not be proven: it may only be larger.
    """

    planner: str | None = None
    iterations: int | None = None
    order: OrderName | None = None
    margin: float | None = None
    metric: float | None = None
    picks: int | None = field(default=None, metadata=LATER)

    def on(self, policy: Policy) -> Policy:
        """The policy with these changes."""
        wished = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(policy, **{name: v for name, v in wished.items() if v is not None})


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Cell(FactsRepr):
    """Everything that a plan depends on besides the scan, covered by one digest.

    The digest does not cover the controller's address and `approvers`, the number of approvals.
    `recipe` is the chosen one of `recipes` (`derived.by_recipe`), 0: none; `bin`: `derived.by_bin`.
    """

    name: str
    robot: Robot
    T_world_robot: pin.SE3
    arms: tuple[Arm, ...]
    bin: Bin
    scanner: ScannerMount
    controller: Controller
    parts: tuple[Part, ...]
    fixtures: tuple[Fixture, ...] = ()
    poses_folder: PosesFolder | None = None
    policy: Policy = field(default_factory=Policy)
    approvers: int = 1
    localizer: LocalizerChoice = field(default_factory=LocalizerChoice, metadata=LATER)
    stations: tuple[Station, ...] = field(default=(), metadata=LATER)
    recipes: tuple[Recipe, ...] = field(default=(), metadata=LATER)
    recipe: int = field(default=NO_RECIPE, metadata=LATER)
    other_bins: tuple[Bin, ...] = field(default=(), metadata=LATER)
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        own(self, "T_world_robot")
        if (carrier := self.scanner.on_arm) is not None:
            T = carrier.T_world_scanner(self.T_world_robot, self.robot, carrier.view.q)
            put(self, scanner=replace(self.scanner, T_world_scanner=T))
        put(self, digest=digest_of(self, without=frozenset({"controller", "approvers"})))

    @property
    def facts(self) -> Mapping[str, object]:
        """What people want to know of it."""
        arms = ", ".join(f"{arm.name} ({arm.tool.name})" for arm in self.arms)
        parts = ", ".join(part.name for part in self.parts)
        link, digest = self.controller.link, self.digest[:12]
        return {"name": self.name, "arms": arms, "parts": parts, "link": link, "digest": digest}

    @property
    def zone(self) -> float:
        """How far corners are rounded: the policy's `zone`, 0 where the robot stops at them."""
        return 0.0 if self.controller.motion.corners == "stop" else self.policy.zone

    @property
    def moves_both_arms(self) -> bool:
        """Whether there are two arms or more, and a controller that can move two at once."""
        return len(self.arms) > 1 and self.controller.motion.arms_at_once > 1

    @property
    def bins(self) -> tuple[Bin, ...]:
        """All bins, by their numbers."""
        return tuple(sorted((self.bin, *self.other_bins), key=lambda box: box.number))

    def joint_values(self, q: Mapping[str, Floats]) -> dict[str, float]:
        """The value [rad or m] of each joint by its name, of the named arms at `q` (n,)."""
        return {
            joint: float(value)
            for arm in self.arms
            if arm.name in q
            for joint, value in zip(arm.joints, q[arm.name], strict=True)
        }

    def arm(self, name: str) -> Arm:
        """The arm of that name.

        Raises:
            InputError: there is none; the message lists those there are.
        """
        for arm in self.arms:
            if arm.name == name:
                return arm
        known = ", ".join(arm.name for arm in self.arms)
        raise InputError(CellText.NO_ARM(cell=self.name, name=repr(name), known=known))

    def T_world_station(self, station: Station) -> pin.SE3:
        """Where a station is; it goes along with its fixture."""
        bases = (f.T_world_fixture for f in self.fixtures if f.name == station.fixture)
        return next(bases, pin.SE3.Identity()) * station.T_base_station

    def part(self, name: str) -> Part:
        """The part of that name.

        Raises:
            InputError: there is none; the message lists those there are.
        """
        for part in self.parts:
            if part.name == name:
                return part
        known = ", ".join(part.name for part in self.parts)
        raise InputError(CellText.NO_PART(cell=self.name, name=repr(name), known=known))

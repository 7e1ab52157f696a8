"""A cell as a folder: `cell.toml` with what a person will want to change, and its robot.

For cells that a program makes; one that people have written is changed in place, so that their
comments stay (`formats/cells/edits.py`).
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.cells.calibrations import record_table
from workbench.formats.cells.recipes import recipe_lines
from workbench.formats.cells.tools import slot_lines
from workbench.formats.files.toml_documents import number, numbers, text
from workbench.formats.files.whole_files import file_name, make_folder, write_whole
from workbench.formats.meshes.triangles import stl_of, surface_of
from workbench.formats.robots.urdf_package import write_package, write_srdf
from workbench.model.cell import Arm, Cell, Fixture, Policy, ScannerMount, Tool
from workbench.model.derived.controller_axes import to_controller
from workbench.model.derived.policies import POLICIES
from workbench.model.geometry import Box, Capsule, Cylinder, Floats, Mesh, Solid, Sphere
from workbench.model.part import DOWN, Bin, PartPlace, Station
from workbench.model.recipes.recipe import names_of
from workbench.model.robot import ArmScanner
from workbench.plugins.options import Options

EMPTYING = "thorough: all lifts, fingers as open as there is room; as-needed; quick"

PutMesh = Callable[[str, bytes], str]
"""Name, content of an STL file [m] -> the file that holds it, next to the cell file."""


def write_cell(folder: Path, cell: Cell, unchecked: Mapping[tuple[str, str], str]) -> Path:
    """Write a cell that `read_cell` gives back, except for its parts, which are named only.

    Args:
        folder: made when missing; files in it are replaced.
        cell: what it is made of.
        unchecked: pairs of links that need no check, with the reasons.

    Returns:
        The cell file.

    Raises:
        FileError: a file cannot be written.
    """
    make_folder(folder)
    write_package(folder / "robot.urdf", cell.robot)
    write_srdf(folder / "robot.srdf", cell.robot.name, unchecked)
    path = folder / "cell.toml"
    write_whole(path, ("\n".join(_lines(folder, cell)) + "\n").encode())
    return path


def _lines(folder: Path, cell: Cell) -> Iterator[str]:
    yield "# World frame: z up.  Lengths in mm, angles in degrees, rpy about fixed axes x, y, z."
    yield f"name = {text(cell.name)}"
    yield f"parts = [{', '.join(text(part.name) for part in cell.parts)}]"
    yield from ("", "[robot]", 'urdf = "robot.urdf"')
    yield 'srdf = "robot.srdf"               # pairs of links that need no check'
    yield from _pose(cell.T_world_robot)
    tools = {tool.name: tool for arm in cell.arms for tool in (arm.tool, *arm.tools)}

    def put_mesh(name: str, content: bytes) -> str:
        file = f"meshes/{file_name(name)}.stl"
        write_whole(folder / file, content)
        return file

    for tool in tools.values():
        yield from tool_lines(tool, put_mesh)
    carrier = cell.scanner.on_arm
    for arm in cell.arms:
        is_carrier = carrier is not None and carrier.arm == arm.name
        yield from _arm(cell, arm, carrier.home if carrier and is_carrier else arm.home)
    for box in cell.bins:
        yield from _bin(box)
    yield from _scanner(cell, put_mesh)
    controller = cell.controller
    yield from ("", "[controller]", f"protocol = {text(controller.link)}")
    yield f"host = {text(controller.host)}"
    yield from (f"port = {controller.port}", f"state_port = {controller.state_port}")
    yield from _options(controller.options)
    if cell.localizer.name:
        yield from ("", "[localizer]", f"name = {text(cell.localizer.name)}")
        yield from _options(cell.localizer.options)
    yield from _policy(cell)
    if cell.poses_folder is not None:
        yield from ("", "[detections]", f"path = {text(cell.poses_folder.path)}")
        yield f"part = {text(cell.poses_folder.part)}"
    for fixture in cell.fixtures:
        yield from _fixture(fixture, put_mesh)
    for station in cell.stations:
        yield from _station(station)
    for recipe in cell.recipes:
        yield from recipe_lines(recipe)


def _options(options: Options) -> Iterator[str]:
    """Keys that a plug-in has of its own, in one line: a table of its own would end this one."""
    if not options:
        return
    # What JSON writes of texts, numbers and flags is TOML as well.
    keys = (f"{key} = {json.dumps(value)}" for key, value in options.items())
    yield f"options = {{ {', '.join(keys)} }}"


def _bin(box: Bin) -> Iterator[str]:
    head = "[[bin]]" if box.number else "[bin]"
    yield from ("", "# Its frame: in the middle of the floor's upper side.", head)
    if box.name:
        yield f"name = {text(box.name)}"
    yield from _pose(box.T_world_bin)
    yield f"size_mm = {_mm(box.size)}          # inside: length, width, height"
    yield f"wall_mm = {number(box.wall * 1000)}"
    if not box.has_walls:
        yield "walls = false             # a surface on which parts lie"
    if box.p_world_drop is not None:
        yield f"drop_back_mm = {_mm(np.array(box.p_world_drop))}"
    for region in box.regions:
        yield from ("", "[[bin.region]]", f"name = {text(region.name)}")
        yield from (*_pose(region.T_bin_region), f"size_mm = {_mm(region.size)}")


def _policy(cell: Cell) -> Iterator[str]:
    policy = cell.policy
    yield from ("", "[policy]")
    yield f"margin_mm = {number(policy.margin * 1000)}      # kept to everything on free legs"
    yield f"near_margin_mm = {number(policy.near_margin * 1000)} # by the tool on straight legs"
    yield f"self_margin_mm = {number(policy.self_margin * 1000)} # between links of one arm"
    yield f"lift_length_mm = {number(policy.lift_length * 1000)}"
    yield f"lift_lean_deg = {number(np.rad2deg(policy.lift_lean))}"
    yield f"speed = {number(policy.speed)}          # share of the joints' speeds"
    yield f"zone = {number(policy.zone)}           # corner rounding, share of a segment"
    yield f"threshold_mm = {number(policy.threshold * 1000)}"
    yield f"planner = {text(policy.planner)}"
    yield f"iterations = {policy.iterations}"
    yield f"order = {text(policy.order)}"
    name = _base(policy)
    usual = POLICIES[name]
    if usual != Policy() or policy.lifts != usual.lifts:
        yield f"emptying = {text(name)}  # {EMPTYING}"
    for key in ("sink", "release"):
        if getattr(policy, key) != getattr(usual, key):
            yield f"{key}_mm = {number(getattr(policy, key) * 1000)}"
    for key in ("free_points", "straight_points", "seconds", "metric", "approval_minutes"):
        if getattr(policy, key) != getattr(usual, key):
            yield f"{key} = {number(getattr(policy, key))}"
    if policy.lifts != usual.lifts:
        yield f"lifts = [{', '.join(map(text, policy.lifts))}]"
    if policy.pair_gap != usual.pair_gap:
        yield f"pair_gap_mm = {number(policy.pair_gap * 1000)}"
    if policy.least_air is not None and policy.least_air != usual.least_air:
        yield f"least_air_mm = {number(policy.least_air * 1000)}"
    for key in ("picks", "stirs"):
        if getattr(policy, key) != getattr(usual, key):
            yield f"{key} = {getattr(policy, key)}"
    for key in ("tcp_speed", "point_speed", "held_speed"):
        if (speed := getattr(policy, key)) is not None:
            yield f"{key}_mm = {number(speed * 1000)}"
    for key in ("manual_speed", "retry_without_scan"):
        if getattr(policy, key):
            yield f"{key} = true"
    if policy.contact_energy is not None:
        yield f"contact_energy_j = {number(policy.contact_energy)}"
    for key in ("stir_speed", "slot_speed"):
        if (speed := getattr(policy, key)) != getattr(usual, key):
            yield f"{key}_mm = {number(speed * 1000)}"
    yield f"approvers = {cell.approvers}             # different people who approve each plan"


def _base(policy: Policy) -> str:
    """The name of the policy that one is made from."""
    # What is written as nothing at all cannot be said on top of it.
    if policy.least_air is not None and len(policy.lifts) > 1:
        return "thorough"
    return "as-needed" if policy.as_needed else "quick"


def _scanner(cell: Cell, put_mesh: PutMesh) -> Iterator[str]:
    scanner = cell.scanner
    yield from ("", "# Its frame is a camera's: z into the picture, x right, y down.", "[scanner]")
    if scanner.on_arm is None:
        yield from _pose(scanner.T_world_scanner)
    yield f"resolution = [{scanner.resolution[0]}, {scanner.resolution[1]}]"
    yield f"field_of_view_deg = {number(np.rad2deg(scanner.field_of_view))}"
    yield f"depth_noise_mm = {number(scanner.depth_noise * 1000)}"
    yield f"near_mm = {number(scanner.near * 1000)}"
    yield f"far_mm = {number(scanner.far * 1000)}"
    yield f"calibration_days = {number(scanner.calibration_days)}"
    usual = ScannerMount(scanner.T_world_scanner)
    for key in ("source", "address", "unit", "cloud_axes"):
        if getattr(scanner, key) != getattr(usual, key):
            yield f"{key} = {text(getattr(scanner, key))}"
    if scanner.while_moving:
        yield "while_moving = true       # a scan is as good while arms move out of its view"
    if scanner.patience != usual.patience:
        yield f"patience_s = {number(scanner.patience)}"
    yield from _options(scanner.options)
    if scanner.calibration is not None:
        record = record_table(scanner.calibration)
        yield from ("", "[scanner.calibration]")
        yield from (f"{key} = {text(value)}" for key, value in record.items())
    if scanner.on_arm is not None:
        yield from _on_arm(scanner.on_arm, cell.arm(scanner.on_arm.arm), put_mesh)


def _on_arm(carrier: ArmScanner, arm: Arm, put_mesh: PutMesh) -> Iterator[str]:
    yield from ("", "# Its pose in the flange's frame.", "[scanner.on_arm]")
    yield f"arm = {text(carrier.arm)}"
    yield from _pose(carrier.T_flange_scanner)
    if carrier.merges_views:
        yield "merge_views = true         # a scan is whole once it has come from each view"
    head = "[[scanner.on_arm.view]]" if carrier.other_views else "[scanner.on_arm.view]"
    for view in carrier.views:
        joints = np.rad2deg(to_controller(arm, view.q))
        yield from ("", head, f"name = {text(view.name)}")
        if view.bin:
            yield f"bin = {text(view.bin)}"
        yield f"joints_deg = {numbers(np.round(joints, 4))}   # as the controller shows them"
    for solid in carrier.housing:
        lines = _solid("scanner", solid.name, solid, put_mesh)
        yield from ("", "[[scanner.on_arm.housing]]", *lines)


def _load(tool: Tool) -> Iterator[str]:
    """What a tool says of its load."""
    if tool.mass is None:
        return
    yield f"mass_g = {number(tool.mass * 1000)}"
    if tool.centre_of_gravity is not None:
        yield f"centre_of_gravity_mm = {_mm(tool.centre_of_gravity)}"
    if tool.inertia is not None:
        six = tool.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        values = ", ".join(f"{value + 0.0:.9g}" for value in six)
        yield f"inertia_kgm2 = [{values}]   # xx, yy, zz, xy, xz, yz"


def tool_lines(tool: Tool, put_mesh: PutMesh) -> Iterator[str]:
    """The table `[[tool]]`, line by line."""
    yield from ("", "# In the flange's frame, z out of the flange.", "[[tool]]")
    yield f"name = {text(tool.name)}"
    yield f"stroke_mm = {_mm(np.array(tool.stroke))}             # smallest, largest opening"
    yield f"press_mm = {number(tool.press * 1000)}"
    if tool.force is not None:
        yield f"force_n = {number(tool.force)}"
    yield from _load(tool)
    for tcp in tool.tcps:
        yield from ("", "[[tool.tcp]]", f"name = {text(tcp.name)}", *_pose(tcp.T_flange_tcp))
        if tcp.touches:
            yield f"touches = [{', '.join(map(text, tcp.touches))}]"
        if tcp.output is not None:
            yield f"output = {tcp.output}"
    if not tool.tcps:
        yield from ("", "[tool.tcp]", *_pose(tool.T_flange_tcp))
    for solid in tool.body:
        yield from ("", "[[tool.body]]", *_solid(tool.name, solid.name, solid, put_mesh))
    for finger in tool.fingers:
        yield from (
            "",
            "[[tool.finger]]",
            *_solid(tool.name, finger.solid.name, finger.solid, put_mesh),
        )
        yield f"opens_along = {numbers(finger.direction)}"


def _mapping(cell: Cell, arm: Arm) -> Iterator[str]:
    if arm.mapping is None:
        return
    slides = [cell.robot.joint(arm.joints[k]).kind == "prismatic" for k in arm.axis_order]
    offsets = arm.mapping.offsets * np.where(slides, 1000, 180 / np.pi)
    yield f"axis_coupling = [{', '.join(map(numbers, arm.mapping.coupling))}]"
    yield f"axis_offsets = {numbers(np.round(offsets, 6))}"


def _arm(cell: Cell, arm: Arm, q_home: Floats) -> Iterator[str]:
    axes = np.argsort(arm.axis_order) + 1
    home = np.rad2deg(to_controller(arm, q_home))
    yield from ("", "[[arm]]", f"name = {text(arm.name)}")
    yield f"controller_id = {text(arm.controller_id)}"
    yield f"flange = {text(arm.flange)}"
    yield f"tool = {text(arm.tool.name)}"
    if len(arm.tools) > 1:
        yield f"tools = [{', '.join(text(tool.name) for tool in arm.tools)}]"
    yield "# Which axis of the controller each joint of the chain is, and its sense there."
    yield f"axes = {numbers(axes)}"
    yield f"signs = {numbers(np.array(arm.axis_signs))}"
    yield f"home_deg = {numbers(np.round(home, 4))}   # as the controller shows it"
    yield from _mapping(cell, arm)
    yield f"acceleration_deg = {number(np.rad2deg(arm.acceleration[0]))}"
    if arm.jerk is not None:
        yield f"jerk_deg = {number(np.rad2deg(arm.jerk[0]))}"
    if arm.moving_mass is not None:
        yield f"moving_mass_kg = {number(arm.moving_mass)}"
    if arm.keeps_parts:
        yield "keeps_parts = true        # they stay at their places, as on a pallet"
    if arm.passes_parts_on:
        yield "passes_parts_on = true    # each is taken away before the arm brings another"
    if arm.needs_roll:
        yield "needs_roll = true         # only parts whose roll the scan shows are put there"
    for slot in arm.tool_slots:
        yield from slot_lines(slot)
    names = names_of(len(arm.Ts_world_place), arm.place_names)
    for T, name in zip(arm.Ts_world_place, names, strict=True):
        yield from ("", "[[arm.place]]", *_place_name(name), *_pose(T))
    for pallet, places in groupby(arm.part_places, key=lambda place: place.pallet):
        if pallet:
            first, *others = places
            yield from ("", "[[arm.place]]", *_part_place(first), *_layers([first, *others]))
        else:
            for place in places:
                yield from ("", "[[arm.place]]", *_part_place(place))


def _place_name(name: str) -> Iterator[str]:
    if name:
        yield f"name = {text(name)}"


def _part_place(place: PartPlace) -> Iterator[str]:
    rpy = np.rad2deg(pin.rpy.matrixToRpy(place.T_world_part.rotation))
    yield from _place_name(place.name)
    if place.part:
        yield f"part = {text(place.part)}"
    yield f"part_position_mm = {_mm(place.T_world_part.translation)}"
    yield f"part_rpy_deg = {numbers(np.round(rpy, 6))}"
    yield f"free_rotation_deg = {number(np.rad2deg(place.free_rotation))}"
    yield f"tolerance_mm = {number(place.tolerance * 1000)}"
    yield f"tolerance_deg = {number(np.rad2deg(place.turn_tolerance))}"
    if place.centred is not None:
        yield f"centred_mm = {number(place.centred[0] * 1000)}"
        yield f"centred_deg = {number(np.rad2deg(place.centred[1]))}"
    if place.approach != DOWN:
        yield f"approach = {numbers(np.round(place.approach, 6))}"


def _layers(places: Sequence[PartPlace]) -> Iterator[str]:
    """The grid of a pallet, whose places come layer by layer, row by row."""
    first = [place for place in places if place.layer == 1]
    T = places[0].T_world_part
    off = np.array([T.actInv(place.T_world_part).translation for place in first])
    columns = int((np.abs(off[:, 1]) < 1e-9).sum())
    rows, layers = len(first) // columns, len(places) // len(first)
    up = (places[len(first)].T_world_part.translation - T.translation)[2]
    x, y = off[min(1, columns - 1), 0], off[columns % len(first), 1]
    yield f"grid = [{columns}, {rows}, {layers}]"
    yield f"pitch_mm = {_mm(np.array([x, y, up]))}"


def _fixture(fixture: Fixture, put_mesh: PutMesh) -> Iterator[str]:
    yield from ("", "[[fixture]]", f"name = {text(fixture.name)}")
    yield from _pose(fixture.T_world_fixture)
    for solid in fixture.solids:
        # Reading puts the name of the fixture before it again.
        name = solid.name.removeprefix(f"{fixture.name}_")
        yield from ("", "[[fixture.solid]]", *_solid(fixture.name, name, solid, put_mesh))


def _station(station: Station) -> Iterator[str]:
    yield from ("", "# Where parts may be put down for a moment.", "[[station]]")
    yield f"name = {text(station.name)}"
    if station.fixture:
        yield f"fixture = {text(station.fixture)}"
    yield from _pose(station.T_base_station)
    yield f"size_mm = {_mm(station.size)}"


def _solid(owner: str, name: str, solid: Solid, put_mesh: PutMesh) -> Iterator[str]:
    yield f"name = {text(name)}"
    yield f"shape = {text(solid.shape.kind)}"
    match solid.shape:
        case Box(size=size):
            yield f"size_mm = {_mm(size)}"
        case Sphere(radius=radius):
            yield f"radius_mm = {number(radius * 1000)}"
        case Cylinder(radius=radius, length=length) | Capsule(radius=radius, length=length):
            yield f"radius_mm = {number(radius * 1000)}"
            yield f"length_mm = {number(length * 1000)}"
        case Mesh() as mesh:
            as_drawn = Solid(name, mesh, pin.SE3.Identity())
            file = put_mesh(f"{owner}_{name}", stl_of(surface_of([as_drawn])))
            yield f"file = {text(file)}"
            yield f'unit = "m"\nconvex = {str(mesh.is_convex).lower()}'
    yield from _pose(solid.T_owner_shape)
    yield f"colour = {numbers(np.round(solid.colour, 3))}"


def _pose(T: pin.SE3) -> Iterator[str]:
    if np.abs(T.translation).max() > 0:
        yield f"position_mm = {_mm(T.translation)}"
    rpy = np.rad2deg(pin.rpy.matrixToRpy(T.rotation))
    if np.abs(rpy).max() > 1e-9:
        yield f"rpy_deg = {numbers(np.round(rpy, 6))}"


def _mm(lengths: Floats) -> str:
    return numbers(np.round(np.asarray(lengths) * 1000, 4))

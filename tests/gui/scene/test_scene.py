"""What is drawn, and that drawing moves things instead of making them anew."""

import asyncio
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from raw_browser import raw_browser

from workbench.app.runtime.live import Live
from workbench.formats.meshes.triangles import triangles_of
from workbench.gui.scene.cloud import GRID
from workbench.gui.scene.contacts import draw_meets
from workbench.gui.scene.picture import ScenePicture, is_other_robot
from workbench.gui.shared.colours import BAD, rgb_of
from workbench.gui.shared.look import Look, Pose
from workbench.gui.shared.playback import joint_values, part_poses
from workbench.gui.shared.viser_server import close_viser, open_viser
from workbench.model.geometry import Box, pose_from_rpy
from workbench.model.part import Region
from workbench.model.scan import LocalizationResult, Objection, RejectedHypothesis
from workbench.planning.kinematics.robot import Kinematics
from workbench.studies.load.raw_browser import unpack


@pytest.fixture
def server():
    server = open_viser("127.0.0.1", 0)
    yield server
    close_viser(server)


@pytest.fixture
def scene(server, cell):
    return ScenePicture(server, cell, most_points=500)


def node(server, name):
    return server.scene.get_handle_by_name(name)


def pose_of(handle) -> np.ndarray:
    return np.concatenate([handle.position, handle.wxyz])


def test_the_cell_stands_there_before_anything_has_happened(server, scene, cell, states, view_of):
    scene.draw(None, view_of(states.idle))
    for name in (
        "/robot/body",
        *(f"/robot/{arm.flange}/{arm.tool.name}" for arm in cell.arms),
        *(f"/fixtures/{fixture.name}" for fixture in cell.fixtures),
        "/bin",
        "/scanner",
    ):
        assert node(server, name) is not None, name
    assert node(server, "/scan") is None
    assert not node(server, "/planned").visible


def test_regions_of_interest_are_drawn_and_go_where_they_are_moved(
    server, scene, cell, states, view_of
):
    region = Region("left", pose_from_rpy((0.0, 0.05, 0.0)), np.array([0.1, 0.1, 0.05]))
    for x in (0.0, 0.03):
        moved = replace(region, T_bin_region=pose_from_rpy((x, 0.05, 0.0)))
        other = replace(cell, bin=replace(cell.bin, regions=(moved,)))
        scene.draw(None, view_of(replace(states.idle, cell=other)))
        T = other.bin.T_world_bin * moved.T_bin_region
        np.testing.assert_allclose(pose_of(node(server, "/regions/0"))[:3], T.translation)
        assert node(server, "/regions/0/edges") is not None
        assert node(server, "/regions/0/label").text == "region left"


def test_no_browser_has_to_draw_shadows_not_even_at_first(server, scene):
    async def look():
        async with raw_browser(server.get_port()) as browser:
            kinds = []
            while "MeshMessage" not in kinds:
                for message in unpack(await browser.recv()):
                    kinds.append(message["type"])
                    if message["type"] == "EnableLightsMessage":
                        assert message["cast_shadow"] is False
            assert "EnableLightsMessage" in kinds

    asyncio.run(asyncio.wait_for(look(), 60))


def test_links_stand_where_forward_kinematics_puts_them(server, scene, cell, states, view_of):
    scene.draw(None, view_of(states.idle))
    for name, T in Kinematics(cell).link_poses({}).items():
        np.testing.assert_allclose(node(server, f"/robot/{name}").position, T.translation)


def test_a_scan_is_thinned_and_dropped_with_its_state(server, scene, states, view_of):
    empty, scanned = view_of(states.idle), view_of(states.scanned)
    scene.draw(None, empty)
    scene.draw(empty, scanned)
    assert len(node(server, "/scan").points) == 500
    scene.draw(scanned, empty)
    assert node(server, "/scan") is None


def test_scrubbing_moves_arms_and_parts_without_making_them_anew(
    server, scene, cell, states, view_of, result
):
    start = view_of(states.planned)
    scene.draw(None, start)
    part, arm = node(server, "/parts/part-1"), node(server, "/planned/right_link_3")
    before = pose_of(part), pose_of(arm)
    end = view_of(states.planned, Look(time=result.plan.cycle_seconds, follows=False))
    scene.draw(start, end)
    assert node(server, "/parts/part-1") is part
    T = part_poses(cell, Kinematics(cell), (result.plan,), end.runs, end.look.time)[0]
    np.testing.assert_allclose(part.position, T.translation)
    assert not np.allclose(pose_of(part), before[0])
    scene.draw(end, start)
    np.testing.assert_allclose(pose_of(part), before[0])
    np.testing.assert_allclose(pose_of(arm), before[1])


def test_fingers_open_for_the_reach_and_close_on_the_part(
    server, scene, cell, states, view_of, result
):
    start = view_of(states.planned)
    arm_plan = result.plan.arms[0]
    arm = cell.arm(arm_plan.arm)
    holding = next(r for r in start.runs if r.arm == arm_plan.arm and r.leg.holding)

    def gap(look: Look) -> float:
        scene.draw(None, view_of(states.planned, look))
        tool = f"/planned/{arm.flange}/{arm.tool.name}"
        a, b = (node(server, f"{tool}/{finger.solid.name}") for finger in arm.tool.fingers)
        return float(np.linalg.norm(np.array(a.position) - b.position))

    assert gap(Look(time=0.5, follows=False)) == pytest.approx(arm_plan.legs[0].opening)
    assert gap(Look(time=holding.start + 0.01, follows=False)) == pytest.approx(holding.leg.opening)


def reported(cell, off=0.0):
    """A controller that reports all joints, so far [rad] from home."""
    return Live(
        joints={j: q + off for arm in cell.arms for j, q in zip(arm.joints, arm.home, strict=True)}
    )


def placed(server, name):
    return np.array(node(server, name).position)


@pytest.mark.parametrize("phase", ["planned", "sending", "fault", "done"])
@pytest.mark.parametrize("follows", [False, True])
def test_the_solid_robot_is_the_real_one_and_the_see_through_one_is_planned(
    server, scene, cell, states, view_of, phase, follows
):
    live = reported(cell, 0.1)
    view = view_of(getattr(states, phase), Look(time=3.0, follows=follows), live)
    scene.draw(None, view)
    real = Kinematics(cell).link_poses(live.joints)["right_link_6"].translation
    planned = Kinematics(cell).link_poses(joint_values(cell, view.moments))["right_link_6"]
    np.testing.assert_allclose(placed(server, "/robot/right_link_6"), real)
    np.testing.assert_allclose(placed(server, "/planned/right_link_6"), planned.translation)
    assert node(server, "/robot").visible and node(server, "/planned").visible
    assert node(server, "/robot/right_link_6").visible


def test_a_planned_robot_that_stands_where_the_real_one_does_is_not_drawn_over_it(
    server, scene, cell, states, view_of
):
    scene.draw(None, view_of(states.planned, Look(), reported(cell)))
    assert not node(server, "/planned").visible


def test_where_nothing_is_reported_a_preview_is_not_drawn_beside_a_robot_at_home(
    server, scene, states, view_of
):
    still, previewed = (
        view_of(states.planned, Look(time=time, follows=False)) for time in (0.0, 2.0)
    )
    scene.draw(None, still)
    moved = states.planned.plan.sequence[0].runs[0][0]
    arm = node(server, f"/robot/{moved}_link_6")
    assert arm.visible and not node(server, "/planned").visible
    scene.draw(still, previewed)
    assert node(server, "/planned").visible and not arm.visible
    scene.draw(previewed, still)
    assert arm.visible and not node(server, "/planned").visible


def grey(colour):
    return max(colour) - min(colour) <= 16


@pytest.mark.parametrize("phase", ["localized", "planned", "fault"])
def test_a_robot_that_is_not_reported_any_more_stays_where_it_was_and_loses_its_colours(
    server, scene, cell, states, view_of, phase
):
    def colours():
        return [mesh.color for mesh in scene._robot._meshes]

    state, here = getattr(states, phase), reported(cell, 0.1)
    alive = view_of(state, Look(time=3.0), here)
    lost = replace(alive, live=Live(last_joints=here.joints, reported_at=alive.at))
    scene.draw(None, alive)
    own, stands = colours(), placed(server, "/robot/right_link_6")
    scene.draw(alive, lost)
    np.testing.assert_array_equal(placed(server, "/robot/right_link_6"), stands)
    assert node(server, "/robot/right_link_6").visible
    assert all(map(grey, colours())) and max(map(max, colours())) < 190
    scene.draw(lost, alive)
    assert colours() == own


def test_hands_of_a_robot_that_is_not_reported_any_more_keep_what_they_held(
    server, scene, cell, states, view_of
):
    held = next(one for one in view_of(states.planned).runs if one.leg.holding)
    time = (held.start + held.end) / 2
    here = reported(cell, 0.1)
    lost = Live(last_joints=here.joints, reported_at=5.0)
    fault = view_of(states.fault, Look(time=time, followed=time), lost)
    scene.draw(None, fault)
    assert node(server, "/lost") is None and node(server, f"/lost/{held.arm}") is None
    seen = view_of(states.scanned, live=lost)
    scene.draw(fault, seen)
    T_tcp_part = states.planned.plan.arm(held.arm).T_tcp_part
    T = Kinematics(cell).tcp_pose(cell.arm(held.arm), seen.real[held.arm].q) * T_tcp_part
    np.testing.assert_allclose(placed(server, f"/lost/{held.arm}"), T.translation)
    # Whoever hears of the robot again looks what its hands hold.
    scene.draw(seen, view_of(states.scanned, live=here))
    assert node(server, f"/lost/{held.arm}") is None


def test_the_points_of_a_part_go_where_the_part_goes(server, scene, cell, states, view_of, scan):
    """What was scanned of a part does not stay in the bin like its shadow."""
    found = states.localized.detections
    surface = np.asarray(triangles_of(cell.part(found[0].part).mesh).vertices)[::20]
    poses = [one.T_world_part for one in found]
    world = np.concatenate([surface @ T.rotation.T + T.translation for T in poses])
    T = cell.scanner.T_world_scanner.inverse()
    seen = replace(scan, points=world @ T.rotation.T + T.translation)
    scene.draw(None, view_of(replace(states.localized, scan=seen)))
    for number in (1, 2):
        own = node(server, f"/parts/part-{number}/points")
        np.testing.assert_allclose(own.points + np.array(own.position), surface, atol=GRID)
    assert len(node(server, "/scan").points) == 0


def test_discarded_poses_are_drawn_when_asked_for_and_of_this_search_only(
    server, scene, cell, states, view_of
):
    T = states.localized.detections[0].T_world_part
    one = RejectedHypothesis(cell.parts[0].name, T, 0.4, Objection.TWIN, 0)
    live = Live(findings=LocalizationResult(states.localized.detections, (one,)))
    hidden, shown = (
        view_of(states.localized, Look(rejected=asked), live) for asked in (False, True)
    )
    scene.draw(None, hidden)
    assert node(server, "/rejected/1") is None
    scene.draw(hidden, shown)
    np.testing.assert_allclose(node(server, "/rejected/1").position, T.translation)
    vetoed = replace(states.localized, detections=states.localized.detections[:1])
    scene.draw(shown, replace(shown, state=vetoed))
    assert node(server, "/rejected/1") is None


def test_a_chosen_candidate_shows_its_tool_and_goes_with_the_choice(server, scene, states, view_of):
    none = view_of(states.planned)
    chosen = replace(none, look=Look(candidate=0))
    scene.draw(None, none)
    assert node(server, "/candidate") is None
    scene.draw(none, chosen)
    np.testing.assert_allclose(
        node(server, "/candidate").position, states.planned.candidates[0].T_world_tcp.translation
    )
    assert node(server, "/grasps") is not None
    scene.draw(chosen, none)
    assert node(server, "/candidate") is None
    assert node(server, "/grasps") is None


def test_a_candidate_refused_without_an_arm_shows_its_hand_and_what_it_meets_in_red(
    server, scene, states, view_of
):
    state, stands = states.localized, pose_from_rpy((0.5, 0.1, 0.2), (np.pi, 0, 0))
    wall = (Box(np.full(3, 0.1)), pose_from_rpy((0.4, 0.1, 0.0), (0, 0, 0)))
    pose = Pose("failed", None, 0.03, "no", (wall,), stands)
    view = view_of(replace(state, candidates=states.planned.candidates[:1]), Look(candidate=0))
    scene.draw(None, replace(view, poses=(pose,)))
    np.testing.assert_allclose(node(server, "/candidate").position, stands.translation)
    assert node(server, "/candidate/tool_0") is not None
    met = node(server, "/meets/0")
    np.testing.assert_allclose(met.position, wall[1].translation)
    assert met.color == rgb_of(BAD)
    scene.draw(replace(view, poses=(pose,)), view_of(state))
    assert node(server, "/meets/0") is None


def test_what_meets_stands_as_it_does_after_something_else_that_was_turned(server):
    """Browsers keep the pose of a removed node for the next one of its name, unless one is sent."""
    box = Box(np.full(3, 0.1))
    sent = []
    buffer = server._websock_server.get_message_buffer()
    push = buffer.push
    buffer.push = lambda message, *rest: (sent.append(message), push(message, *rest))[1]
    turned = pose_from_rpy((0.4, 0.1, 0.2), (1.0, 0.5, 0.2))
    for T in (turned, pose_from_rpy((0.0, 0.0, 0.0))):
        sent.clear()
        draw_meets(server.scene, "/meets", ((box, T),))
        poses = {
            kind: [m for m in sent if type(m).__name__ == kind and m.name == "/meets/0"]
            for kind in ("SetOrientationMessage", "SetPositionMessage")
        }
        q = pin.Quaternion(T.rotation)
        np.testing.assert_allclose(
            poses["SetOrientationMessage"][-1].wxyz, (q.w, q.x, q.y, q.z), atol=1e-9
        )
        np.testing.assert_allclose(
            poses["SetPositionMessage"][-1].position, T.translation, atol=1e-9
        )


def test_a_candidate_refused_at_a_configuration_shows_the_arm_there(
    server, scene, cell, states, view_of
):
    arm = cell.arm("left")
    q = np.asarray(arm.home) + 0.1
    refused = next(c for c in states.planned.candidates if c.arm == "left")
    refused = replace(refused, verdict=replace(refused.verdict, q=q))
    state = replace(states.localized, candidates=(refused,))
    view = view_of(state, Look(candidate=0))
    bin_wall = (Box(np.array([0.01, 0.2, 0.05])), pose_from_rpy((0.4, 0.1, 0.0)))
    pose = Pose("where it failed: grasp", q, 0.04, "in collision", (bin_wall,))
    scene.draw(None, replace(view, poses=(pose,)))
    expected = Kinematics(cell).link_poses(dict(zip(arm.joints, q, strict=True)))
    shown = node(server, "/candidate_left/left_link_5")
    np.testing.assert_allclose(shown.position, expected["left_link_5"].translation)
    np.testing.assert_allclose(node(server, "/meets/0").position, (0.4, 0.1, 0.0))


def test_collision_shapes_stand_where_the_robot_does_from_the_first(
    server, scene, cell, states, view_of
):
    looks = view_of(states.idle)
    shapes = replace(looks, look=Look(shapes=True))
    scene.draw(None, looks)
    scene.draw(looks, shapes)
    for name, T in Kinematics(cell).link_poses({}).items():
        np.testing.assert_allclose(
            node(server, f"/robot_checked/{name}").position, T.translation, err_msg=name
        )


def test_a_scan_is_coloured_anew_when_the_bin_is_moved(server, scene, cell, states, view_of):
    scanned = view_of(states.scanned)
    scene.draw(None, scanned)
    before = np.array(node(server, "/scan").colors)
    away = replace(cell.bin, T_world_bin=pose_from_rpy((2.0, 0.0, 0.0)) * cell.bin.T_world_bin)
    moved = replace(scanned, state=replace(states.scanned, cell=replace(cell, bin=away)))
    scene.draw(scanned, moved)
    assert not np.array_equal(node(server, "/scan").colors, before)


@pytest.mark.parametrize(("asked", "shown"), [(-7, 0), (0, 0), (1, 1), (99, 1)])
def test_a_pose_that_does_not_exist_shows_the_nearest_one(states, view_of, asked, shown):
    poses = tuple(Pose(f"{k}", np.zeros(7), 0.0, "") for k in range(2))
    view = replace(view_of(states.planned, Look(pose=asked)), poses=poses)
    assert view.pose is poses[shown]


def test_a_robot_whose_tool_sits_on_another_link_is_another_robot(cell):
    first, *others = cell.arms
    elsewhere = replace(first, flange=cell.robot.links[0].name)
    assert is_other_robot(cell, replace(cell, arms=(elsewhere, *others)))
    assert not is_other_robot(cell, replace(cell, arms=tuple(cell.arms)))

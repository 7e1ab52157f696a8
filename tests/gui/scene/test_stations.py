"""Parts over a station as the page shows them: what legs are called, and each part once."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.core.state import Phase, State
from workbench.app.picking.row import plan_row
from workbench.app.picking.stations import put_down
from workbench.formats.cells.reading import read_cell
from workbench.gui.plan.curves import doing, lanes_html
from workbench.gui.plan.views import plan_html
from workbench.gui.scene.picture import ScenePicture
from workbench.gui.shared.look import Look
from workbench.gui.shared.playback import part_poses, timeline
from workbench.gui.shared.viser_server import close_viser, open_viser
from workbench.model.digest import digest_of
from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import Proven
from workbench.model.scan import Detection
from workbench.planning.kinematics.robot import Kinematics


@pytest.fixture(scope="module")
def over():
    return read_cell("robots/yumi/regrasp.toml")


@pytest.fixture(scope="module")
def planned(over):
    """One part that goes from one arm over the post to the other one."""
    p = over.bin.T_world_bin.translation + np.array([0.03, -0.05, 0.0191])
    found = (Detection("keyed_cylinder", pose_from_rpy(p, (np.pi / 2, 0.0, 0.4)), 0.9),)
    result = plan_row(over, found, digest_of(found))
    assert len(result.plans) == 2
    return State(
        over,
        phase=Phase.PLANNED,
        detections=found,
        plan=result.plan,
        proof=result.proof,
        row=result.row,
        seconds=tuple(result.seconds.items()),
    )


@pytest.fixture(scope="module")
def stands(planned):
    """Where the part stands in between, as the second plan was proven."""
    return planned.plans[1].detections[0].T_world_part.translation


@pytest.fixture
def scene(over):
    server = open_viser("127.0.0.1", 0)
    yield ScenePicture(server, over, most_points=500)
    close_viser(server)


def node(scene, name):
    return scene._scene.get_handle_by_name(name)


def seen(scene):
    """Where parts are drawn now."""
    names = ("/parts/part-1", *(f"/placed/{number}" for number in range(3)))
    handles = [handle for name in names if (handle := node(scene, name)) is not None]
    return [np.array(handle.position) for handle in handles]


def between(state):
    """[s] When the part is alone on the station."""
    runs = timeline(*state.plans)
    return next(run.end for run in runs if run.words == "put on station") + 0.2


def second(state):
    """The second plan is on its way; the part is on the station by the record of the first."""
    (follows,) = state.row
    return replace(
        state,
        phase=Phase.SENDING,
        plan=follows.plan,
        proof=follows.proof,
        row=(),
        sent_before=(Proven(state.plan, state.proof),),
        placed=put_down(state.cell, state.plan),
    )


@pytest.mark.extensive
def test_legs_over_a_station_have_names_of_their_own(over, planned):
    runs = timeline(*planned.plans)
    assert [run.words for run in runs] == [
        *("reach", "approach", "extract", "return", "put on station", "home"),
        *("reach", "hand over", "hand over", "return", "place", "home"),
    ]
    html = lanes_html(over, runs, runs[-1].end)
    assert all(f"</i>{word}</span>" in html for word in ("put on station", "hand over"))
    assert str(doing(runs, runs[7].start + 0.01)) == f"{runs[7].arm}: hand over"


def test_the_same_arm_regrasps(planned):
    first, second = planned.plans
    same = replace(second, arms=(replace(second.arms[0], arm=first.arms[0].arm),))
    steps = tuple(
        replace(one, runs=tuple((first.arms[0].arm, leg) for _, leg in one.runs))
        for one in second.sequence
    )
    words = [run.words for run in timeline(first, replace(same, sequence=steps))]
    assert words[7:9] == ["regrasp", "regrasp"] and "hand over" not in words


def test_a_part_never_leaps_on_its_way_over_a_station(over, planned, stands):
    kinematics, runs = Kinematics(over), timeline(*planned.plans)
    times = np.linspace(0.0, runs[-1].end, 800)
    way = np.array(
        [part_poses(over, kinematics, planned.plans, runs, time)[0].translation for time in times]
    )
    drop = over.policy.margin + 0.001
    # An arm carries a part a metre and a half in a second at most.
    assert np.linalg.norm(np.diff(way, axis=0), axis=1).max() < drop + 1.5 * times[1]
    rests = (times > between(planned)) & (times < runs[8].start)
    np.testing.assert_allclose(way[rests], np.tile(stands, (rests.sum(), 1)), atol=1e-6)


def test_a_part_that_stands_on_a_station_is_counted_once(planned):
    html = plan_html(planned)
    assert "2 plans in a row, 1 part," in html and "over a station" in html


def test_a_station_is_drawn_where_its_fixture_stands_and_goes_along(scene, over, planned, view_of):
    (station,) = over.stations
    before = view_of(State(over))
    scene.draw(None, before)
    T = over.T_world_station(station)
    np.testing.assert_allclose(node(scene, "/stations/post").position, T.translation)
    assert node(scene, "/stations/post/label").text == "station post"
    fixtures = tuple(
        replace(one, T_world_fixture=pose_from_rpy((0.3, 0.1, 0.12))) if one.name == "post" else one
        for one in over.fixtures
    )
    scene.draw(before, view_of(State(replace(over, fixtures=fixtures))))
    np.testing.assert_allclose(node(scene, "/stations/post").position, (0.3, 0.1, 0.12))
    scene.draw(None, view_of(State(replace(over, fixtures=fixtures, stations=()))))
    assert node(scene, "/stations/post") is None


def test_a_part_on_a_station_is_seen_once_while_the_second_plan_takes_it(
    scene, planned, stands, view_of
):
    state = second(planned)
    np.testing.assert_allclose(state.placed[0].T_world_part.translation, stands, atol=1e-6)
    on_it = view_of(state, Look(time=between(planned)))
    scene.draw(None, on_it)
    (at,) = seen(scene)
    np.testing.assert_allclose(at, stands, atol=1e-6)
    scene.draw(on_it, view_of(state, Look(time=timeline(*state.plans)[9].start)))
    (at,) = seen(scene)
    assert at[2] > stands[2] + 0.02


def test_after_a_row_that_broke_off_a_part_is_seen_on_the_station(scene, planned, stands, view_of):
    placed = put_down(planned.cell, planned.plan)
    broken = replace(planned, phase=Phase.DONE, row=(), placed=placed)
    end = timeline(broken.plan)[-1].end
    done = view_of(broken, Look(time=end))
    scene.draw(None, done)
    (at,) = seen(scene)
    np.testing.assert_allclose(at, stands, atol=1e-6)
    played = view_of(broken, Look(time=0.0, follows=False))
    scene.draw(done, played)
    (at,) = seen(scene)
    assert at[2] < stands[2], "what is played has the part in the bin"
    # Nobody knows: plans keep clear of where it may stand.
    faulty = view_of(replace(broken, phase=Phase.FAULT), Look(time=0.0))
    scene.draw(played, faulty)
    assert len(seen(scene)) == 2
    later = State(planned.cell, placed=placed)
    scene.draw(faulty, view_of(later))
    (at,) = seen(scene)
    np.testing.assert_allclose(at, stands, atol=1e-6)

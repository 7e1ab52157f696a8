"""Two bins emptied in a row over HTTP: simulated scans, real plans, a simulated controller."""

from dataclasses import replace

import pytest
from api_site import Site, serve_site
from forking import fork_workers
from patient import PATIENT, in_threads

from workbench.app.records.replay import replay
from workbench.app.review.recompute import recompute_tasks
from workbench.app.runtime.bench import Bench
from workbench.devices.abb_simulated.controller import SimulatedController, Simulation
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.journal.journal import Journal
from workbench.model.digest import digest_of
from workbench.model.recipes.recipe import Recipe

LEFT_ARM = Recipe(1, "by the left arm", strategy="left")


@pytest.fixture
def cell():
    return replace(read_cell(find("robots", "yumi") / "two_bins.toml"), recipes=(LEFT_ARM,))


@pytest.fixture
def real_site(cell, tmp_path, monkeypatch):
    """A bench with its worker and a controller, asked over HTTP."""
    fork_workers(monkeypatch)
    with in_threads() as started:
        robot = started(SimulatedController(cell, Simulation(speed=50), patience=PATIENT))
        at = {"port": robot.port, "state_port": robot.state_port}
        cell = replace(cell, controller=replace(cell.controller, **at))
        bench = Bench(cell, Journal(tmp_path / "session"))
        with serve_site(bench) as (url, session):
            yield Site(bench, None, url, session, tmp_path / "session")
        bench.close()


def plan_by_steps(site, seed):
    for path, body, phase in (
        ("/scan", {"parts": 1}, "scanned"),
        ("/localize", {}, "localized"),
        ("/plan", {}, "planned"),
    ):
        assert site.post(path, seed=seed, **body).ok
        site.reach(phase)


def take(site):
    plan = site.get("/state").json()["plan"]
    for path in ("/watch", "/approve", "/send"):
        assert site.post(path, plan=plan).ok
    site.reach("done")


@pytest.mark.extensive
def test_two_bins_are_emptied_and_the_session_is_computed_again(real_site, tmp_path):
    site = real_site
    cell = site.bench.state.cell
    plan_by_steps(site, seed=3)
    take(site)
    # Nothing is left in the right bin: the next one is scanned by itself.
    assert site.post("/go-on", seed=4, parts=0).ok
    site.reach("planned")
    state = site.get("/state").json()
    assert (state["bin"], state["empty_bins"]) == ("left", ["right"])
    T_bin_world = site.bench.state.cell.bin.T_world_bin.inverse()
    for found in site.bench.state.detections:
        assert abs(T_bin_world.act(found.T_world_part.translation)[1]) < 0.07
    take(site)
    assert site.post("/recipe", number=1).ok
    plan_by_steps(site, seed=5)
    state = site.get("/state").json()
    assert (state["bin"], state["recipe"], state["strategy"]) == ("left", 1, "left")
    take(site)
    assert site.post("/go-on", seed=6, parts=0).ok
    site.reach("scanned")
    state = site.get("/state").json()
    assert state["empty_bins"] == ["right", "left"]
    assert "nothing is left to take in any bin" in state["message"]
    assert site.post("/new-bin", who="bob", name="right").ok
    assert site.post("/bin", name="right").ok
    plan_by_steps(site, seed=7)
    last = site.bench.state
    assert (last.cell.bin.name, last.cell.recipe, last.empty_bins) == ("right", 1, ("left",))
    site.bench.close()
    *_, (_, again) = replay(Journal(tmp_path / "session"), cell)
    assert digest_of(again) == digest_of(last)
    tasks = list(recompute_tasks(Journal(tmp_path / "session")))
    assert {task.says for task in tasks} == {"equal"} and len(tasks) > 10

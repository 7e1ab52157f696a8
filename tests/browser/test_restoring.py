"""A backup restored from the page: told first, kept first, refused where it must be."""

import shutil
import zipfile
from functools import partial

import pytest
from hands import field, pause, unfold

from workbench.app.records.keeping import WITHOUT_SESSIONS, write_backup
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.runtime.watch import CellWatch
from workbench.formats.cells.reading import cell_path, read_cell
from workbench.formats.files.shipped import find
from workbench.journal.journal import Journal


@pytest.fixture
def own(tmp_path, monkeypatch):
    """A working directory with a cell, a part and a backup of both, in which the bin was moved."""
    for kind, name in (("robots", "yumi"), ("parts", "keyed_cylinder")):
        shutil.copytree(find(kind, name), tmp_path / kind / name)
    monkeypatch.chdir(tmp_path)
    write_backup(tmp_path, tmp_path / "kept.zip", WITHOUT_SESSIONS, {})
    cell = tmp_path / "robots" / "yumi" / "cell.toml"
    text = cell.read_text()
    assert "[410, 0, -5]" in text
    cell.write_text(text.replace("[410, 0, -5]", "[420, 0, -5]"))
    return tmp_path


@pytest.fixture
def bench(own):
    machines = partial(EffectRunner, cell_file=cell_path("yumi"))
    bench = Bench(read_cell("yumi"), Journal(own / "session"), effects=machines)
    watch = CellWatch(cell_path("yumi"), bench)
    yield bench
    watch.close()
    bench.close()


def chosen(screen, file) -> None:
    with screen.page.expect_file_chooser() as chooser:
        screen.press("Choose a backup")
    chooser.value.set_files(file)


def test_a_backup_is_told_kept_and_restored(screen, bench, wait, own):
    screen.tab("Statistics")
    unfold(screen, "Restore a backup")
    broken = own / "broken.zip"
    with zipfile.ZipFile(own / "kept.zip") as old, zipfile.ZipFile(broken, "w") as new:
        for name in old.namelist():
            new.writestr(name, old.read(name) if not name.endswith("part.toml") else b"name = 3")
    chosen(screen, broken)
    screen.wait_for("part.toml")
    assert screen.button("Restore it").is_disabled()

    chosen(screen, own / "kept.zip")
    screen.wait_for("Cell yumi")
    screen.wait_for("is replaced")
    screen.wait_for("stays the same")
    assert bench.state.cell.bin.T_world_bin.translation[0] == pytest.approx(0.42)
    screen.shoot("statistics-restore")
    screen.press("Restore it")
    screen.wait_for("kept.zip is restored")
    wait(lambda: bench.state.cell.bin.T_world_bin.translation[0] < 0.415, "the bin back")
    (before,) = (own / "backups").glob("before-*.zip")
    with zipfile.ZipFile(before) as kept:
        assert b"[420, 0, -5]" in kept.read("robots/yumi/cell.toml")
    assert "kept.zip" in (own / "backups" / "changes.log").read_text()

    pause(screen.page, 200)
    field(screen, "Or one kept here").click()
    screen.page.get_by_role("option", name=before.name).click()
    screen.wait_for(f"Changes by {before.name}:")
    assert screen.errors == []

"""A bench and its page in a folder of their own, to which cells and parts can be written."""

import shutil
from functools import partial
from pathlib import Path

import pytest

from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.formats.cells.reading import cell_path, part_folders, read_cell
from workbench.formats.files.shipped import find
from workbench.gui.page.server import serve
from workbench.journal.journal import Journal


@pytest.fixture
def own(tmp_path, monkeypatch) -> Path:
    """A working directory with its own robots and parts, that may be written to."""
    for kind in ("robots", "parts", "static"):
        shutil.copytree(find("robots", "yumi").parent.parent / kind, tmp_path / kind)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def own_bench(own):
    machines = partial(EffectRunner, cell_file=cell_path("yumi"))
    bench = Bench(read_cell("yumi"), Journal(own / "session"), effects=machines)
    yield bench
    bench.close()


@pytest.fixture
def own_url(own_bench):
    page = serve(own_bench, port=0, most_points=4000, folders=part_folders(cell_path("yumi")))
    yield page.url
    page.close()

"""While the journal hangs in an append, the interface answers and a stop acts."""

import threading

import pytest
from hung_disk import HungDisk
from waiting import wait_until

from workbench.app.core.cycle.scanning import TakeScan


@pytest.mark.parametrize("heartbeat", [0.05])
def test_streams_come_and_go_and_the_state_is_read(site, monkeypatch):
    with HungDisk(site.bench._journal, monkeypatch).during(site.bench.do, TakeScan(), "Ada"):
        with site.get("/events", stream=True) as stream:
            lines = stream.iter_lines(decode_unicode=True)
            assert next(lines).startswith("id: ")
        watching = [thread for thread in threading.enumerate() if thread.name == "observer"]
        # The stream that has gone takes its observer along.
        wait_until(lambda: not any(thread.is_alive() for thread in watching))
        assert site.get("/state").json()["phase"] == "idle"

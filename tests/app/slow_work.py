"""Jobs of a worker that first gets ready, until a file appears; for the tests of what waits."""

import os
import time
from pathlib import Path

from tiny_work import JOBS  # noqa: F401

from workbench.app.runtime.readiness import NOTE


def GET_READY(report):
    go = Path(os.environ["TINY_GO"])
    report(0.4, NOTE)
    while not go.exists():
        time.sleep(0.01)
    report(0.9, NOTE)

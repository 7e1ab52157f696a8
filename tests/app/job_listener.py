"""What `Jobs` tells, collected; and the processes that it has."""

import multiprocessing
import queue

from waiting import PATIENCE


class Listener:
    """Collects what a `Jobs` tells."""

    def __init__(self):
        self.results = queue.Queue()
        self.progress = queue.Queue()

    def ended(self, number, result):
        self.results.put((number, result))

    def progressed(self, number, done, note):
        self.progress.put((number, done, note))

    def result(self):
        return self.results.get(timeout=PATIENCE)


def workers() -> list[int]:
    return [p.pid for p in multiprocessing.active_children() if p.name == "workbench worker"]


def worker_of(jobs, listener, number=1000) -> int:
    jobs.start(number, "echo", {})
    ended, result = listener.result()
    assert ended == number
    return result["process"]

"""Effects for a bench that records and decides, and moves nothing."""

from workbench.app.runtime.live import Live


class Idle:
    """Effects that are not carried out."""

    def __init__(self, cell, do, now):
        self.live = Live()
        self.asked = []

    def run(self, effect):
        pass

    def ask(self, question):
        self.asked.append(question)

    def close(self):
        pass

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


class Noting:
    """Effects that are noted as `jobs`, for a test that answers them itself."""

    def __init__(self, cell, do, now):
        self.live, self.jobs, self.cell = Live(), [], cell

    def run(self, effect):
        self.jobs.append(effect)

    def close(self):
        pass

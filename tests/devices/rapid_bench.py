"""Small RAPID programs, run in a time that goes as fast as they wait."""

from workbench.devices.rapid.controller import MAKERS
from workbench.devices.rapid.tasks import Meetings, Task
from workbench.devices.rapid.waiting import Signals, Waiting
from workbench.formats.rapid.loading import Loaded, read_source
from workbench.formats.rapid.texts import NATIVES


class Tasks:
    """Tasks without robots; `texts` (task -> modules) are their programs."""

    def __init__(self, texts, *, signals=(), answers=()):
        self.now = 0.0
        self.covered, self.shared, self.written = set(), {}, []
        self.signals, self.answers = Signals(), list(answers)
        meetings = Meetings(list(texts))
        self.tasks = {}
        for name, modules in texts.items():
            task = self.tasks[name] = Task(name, lambda: self.now, self.covered)
            waiting = Waiting(
                task,
                meetings,
                self.signals,
                lambda *_: self.answers.pop(0) if self.answers else None,
                lambda _, text: self.written.append(text),
            )
            task.loaded = Loaded(
                [read_source(f"m{k}", text) for k, text in enumerate(modules)],
                task,
                natives={**NATIVES, **waiting.natives()},
                makers=MAKERS,
                shared=self.shared,
                signals=dict.fromkeys(signals, "signaldo"),
                on_error=task.set_errno,
            )

    def start(self):
        for task in self.tasks.values():
            task.loaded.check()
            task.start()
        return self

    def run(self, seconds=1e6):
        """Until nothing runs any more, or so long."""
        until = self.now + seconds
        while self.now < until:
            running = [task for task in self.tasks.values() if task.is_running]
            if not running:
                return self
            ready = [task for task in running if task.is_ready()]
            for task in ready:
                task.resume()
            self.now += 0.0001 if ready else 0.001
        return self

    def end(self):
        for task in self.tasks.values():
            task.take_pointer()


def module(body, rest=""):
    return f"MODULE m\n{rest}\nPROC main()\n{body}\nENDPROC\nENDMODULE"


def written(body, rest="", **how):
    """What a program writes; an error that nothing takes is its last line."""
    one = Tasks({"T": [module(body, rest)]}, **how).start().run()
    why = one.tasks["T"].stopped_by
    return one.written + ([] if why == "the program has ended" else [why])


def problems(body, rest="", **how):
    """What is wrong with a program, as line, column and words; the body begins in line 4."""
    found = sorted(Tasks({"T": [module(body, rest)]}, **how).tasks["T"].loaded.problems)
    return [(one.line, one.column, one.what) for one in found]

"""The end of `workbench serve`: first the robot, then what may take its time."""

from contextlib import contextmanager
from types import SimpleNamespace

from idle import Idle

from workbench.cli.main import main
from workbench.cli.serving import serve


def test_the_robot_is_stopped_before_places_of_anchors_are_waited_for(monkeypatch, tmp_path):
    ended = []

    class Noted(Idle):
        def __init__(self, cell, do, now, cell_file):
            super().__init__(cell, do, now)

        def run(self, effect):
            ended.append(type(effect).__name__)

    class Slow:
        def __init__(self, *_):
            pass

        def close(self):
            ended.append("anchors")

    @contextmanager
    def page(*_, **__):
        yield SimpleNamespace(link="")
        ended.append("page")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(serve, "_answers", lambda controller: True)
    monkeypatch.setattr(serve, "EffectRunner", Noted)
    monkeypatch.setattr(serve, "Anchors", Slow)
    monkeypatch.setattr(serve, "fronted", page)
    monkeypatch.setattr(serve, "wait_for_the_end", lambda *lines: None)
    assert main(["serve", "--port", "0", "--users", str(tmp_path / "users.sqlite")]) == 0
    assert ended == ["StopSending", "page", "anchors"]

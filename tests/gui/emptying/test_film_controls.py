"""The slider of a film shows the moment that the scene shows."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from workbench.gui.emptying.film_controls import FilmControls
from workbench.gui.shared.own import Showing
from workbench.gui.shared.viser_server import open_viser


@pytest.fixture
def gui():
    server = open_viser("127.0.0.1", 0, "secret")
    yield server.gui
    server.stop()


class Own:
    def __init__(self, film):
        self.now = SimpleNamespace(film=film)

    def show(self, change):
        self.now = SimpleNamespace(film=change(self.now.film))


class Slider:
    """Of a browser: what is written into it."""

    max, disabled = 10.0, False

    def __init__(self):
        self.written = []

    def __setattr__(self, name, value):
        if name == "value":
            self.written.append(value)
        super().__setattr__(name, value)


@pytest.mark.parametrize("is_playing", [True, False])
@pytest.mark.parametrize(("heard", "late"), [(1, 0), (2, 0), (1, 1)])
def test_a_moment_that_is_typed_after_the_film_moved_the_slider_is_written_once_more(
    gui, is_playing, heard, late
):
    own, hands = Own(Showing(None, 10.0, {}, 5.57, is_playing)), []
    visitor = SimpleNamespace(
        gui=gui,
        own=own,
        by_hand=lambda control, used: hands.append(used),
        allow=lambda button, problem: None,
    )
    controls = FilmControls(visitor)
    slider = controls._time = Slider()

    def view():
        state, live = SimpleNamespace(emptying=None), SimpleNamespace(films=None)
        return SimpleNamespace(state=state, live=live, own=own.now, filmed=None)

    controls.show(None, before := view(), 0)
    assert slider.written == [5.57]
    own.show(lambda showing: replace(showing, time=5.6))
    last = view()
    for _ in range(heard):
        hands[0](1.0)
    for _ in range(late):
        controls.show(before, last, 0)
    controls.show(last, after := view(), 0)
    assert slider.written[-1] == 1.0 and len(slider.written) > 1
    # While it stands, the browser that drags knows best.
    slider.written.clear()
    hands[0](2.0)
    controls.show(after, view(), 0)
    assert slider.written == []

"""Icons are those of viser, and are read once whatever comes."""

import zipfile

import pytest
from viser import _gui_api, _gui_handles, _icons

from workbench.gui.shared.icons import svg_of
from workbench.gui.shared.viser_server import close_viser, open_viser

with zipfile.ZipFile(_icons.ICONS_DIR / "tabler-icons.zip") as archive:
    MANY = [name.removesuffix(".svg") for name in archive.namelist() if name.endswith(".svg")][:40]
"""More than viser keeps."""


def test_an_icon_is_the_one_that_viser_reads():
    assert svg_of("player-play") == _icons.svg_from_icon("player-play")
    assert svg_of("player-play").startswith("<svg")
    with pytest.raises(KeyError):
        svg_of("no such icon")


def test_buttons_behind_a_door_read_the_archive_once(monkeypatch):
    server = open_viser("127.0.0.1", 0)
    try:
        button = server.gui.add_button("first", icon=MANY[0])
        monkeypatch.setattr(zipfile, "ZipFile", None)
        for icon in MANY * 2:
            server.gui.add_button(icon, icon=icon)
        button.icon = MANY[1]
        assert button._impl.props._icon_html == svg_of(MANY[1])
    finally:
        close_viser(server)


def test_viser_takes_icons_where_it_is_told_to():
    for module in (_gui_api, _gui_handles):
        assert module.svg_from_icon is svg_of

"""The icons of tabs and buttons, read from viser's archive once and kept; what opens a tab.

viser 1.1.1 keeps 32 icons and reads the directory of its archive, some four thousand entries, for
every other one.  The page shows more kinds than that, each in the same order for each browser: none
was ever kept, and the drawing stood still for more than a second whenever a browser came.  Viser's
internals are used here; its version is pinned, and `tests/gui/shared/test_icons.py` shows when they
change.
"""

# pyright: reportPrivateUsage=false

import functools
import io
import zipfile
from collections.abc import Mapping
from html import escape
from typing import Any

import viser
from viser import _gui_api, _gui_handles, _icons

TAB_ICONS: Mapping[str, viser.IconName] = {
    "Recorded": viser.Icon.HISTORY,
    "Cycle": viser.Icon.ROTATE_CLOCKWISE,
    "Parts": viser.Icon.PACKAGES,
    "Candidates": viser.Icon.LIST_CHECK,
    "Plan": viser.Icon.ROUTE,
    "Robot": viser.Icon.ROBOT,
    "Grasps": viser.Icon.HAND_GRAB,
    "Cell": viser.Icon.BUILDING_FACTORY_2,
    "Emptying": viser.Icon.BUCKET,
    "Calibration": viser.Icon.FOCUS_CENTERED,
    "Statistics": viser.Icon.CHART_BAR,
}
"""By the title of a tab; tabs of plug-ins have `PUZZLE`."""


def keep_icons() -> None:
    """Have viser take icons from here; twice does no harm."""
    modules: tuple[Any, ...] = (_gui_api, _gui_handles)
    for module in modules:
        module.svg_from_icon = svg_of


@functools.cache
def svg_of(name: str) -> str:
    """An icon of Tabler as an `<svg>` element, by its name.

    Concurrency: any thread.

    Raises:
        KeyError: there is none of that name.
    """
    return _archive().read(f"{name}.svg").decode("utf-8")


@functools.cache
def _archive() -> zipfile.ZipFile:
    return zipfile.ZipFile(io.BytesIO((_icons.ICONS_DIR / "tabler-icons.zip").read_bytes()))


def opens_tab(title: str) -> str:
    """Attributes of an element on which a click, Enter or the space bar opens that tab."""
    # Tabs hear no click that a script makes, but what a person's Enter does.
    enter = "new KeyboardEvent('keydown',{key:'Enter',bubbles:true})"
    tab = f"[role=tab]:has(.icon-tabler-{escape(TAB_ICONS[title])})"
    press = f"document.querySelector('{tab}')?.dispatchEvent({enter})"
    key = f"if(event.key==='Enter'||event.key===' '){{event.preventDefault();{press}}}"
    return f'tabindex="0" role="button" onclick="{press}" onkeydown="{key}"'

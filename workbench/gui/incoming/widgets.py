"""What the widgets of a page offer: which can be used, and which values each one takes."""

# pyright: reportPrivateUsage=false

from collections.abc import Callable
from typing import Any

import viser

from workbench.gui.incoming.values import number_problem, numbers_problem, text_problem

NOT_THERE = "it is not there"
NOT_SHOWN = "it is not shown"
NOT_NOW = "it cannot be used now"

BRIGHTEST = 255


def widget_of(uuid: str, *pages: viser.GuiApi) -> Any | None:
    """The widget with an id in these pages; None when there is none."""
    for gui in pages:
        widget: Any = gui._gui_input_handle_from_uuid.get(uuid)
        if widget is not None and not widget._impl.removed:
            return widget
    return None


def use_problem(widget: Any | None) -> str:
    """Why a widget cannot be used at all; empty when it can."""
    if widget is None:
        return NOT_THERE
    shape = widget._impl.props
    if not shape.visible or not _is_around_shown(widget):
        return NOT_SHOWN
    return NOT_NOW if getattr(shape, "disabled", False) else ""  # a bar of progress never is


def value_problem(widget: Any, value: Any) -> str:
    """Why a widget does not offer a value; empty when it does."""
    now, shape = widget._impl.value, widget._impl.props
    match widget:
        case viser.GuiButtonHandle():
            return "" if value is True else "no press"
        case viser.GuiCheckboxHandle():
            return "" if isinstance(value, bool) else "neither on nor off"
        case viser.GuiDropdownHandle() | viser.GuiButtonGroupHandle():
            return "" if value in shape.options else "none of the options"
        case viser.GuiTextHandle():
            return "" if value == now else text_problem(value, has_lines=shape.multiline)
        case (
            viser.GuiNumberHandle()
            | viser.GuiSliderHandle()
            | viser.GuiVector2Handle()
            | viser.GuiVector3Handle()
            | viser.GuiMultiSliderHandle()
        ):
            return _beyond(widget, shape, value, now)
        case viser.GuiRgbHandle() | viser.GuiRgbaHandle():
            low, high = [0] * len(now), [BRIGHTEST] * len(now)
            return numbers_problem(value, now, low=low, high=high, step=1, digits=0)
        case _:
            return "nothing that could be sent"


def _beyond(widget: Any, shape: Any, value: Any, now: Any) -> str:
    """What is wrong with one number, or with several, of a widget with bounds."""
    low: Any = shape.min
    high: Any = shape.max
    check: Callable[..., str] = numbers_problem
    if isinstance(widget, viser.GuiNumberHandle | viser.GuiSliderHandle):
        check = number_problem
    elif isinstance(widget, viser.GuiMultiSliderHandle):
        low, high = [low] * len(now), [high] * len(now)
    problem = check(value, now, low=low, high=high, step=shape.step, digits=shape.precision)
    if not problem and isinstance(widget, viser.GuiMultiSliderHandle):
        return "" if list(value) == sorted(value) else "not in order"
    return problem


def key_problem(uuid: str, *pages: viser.GuiApi) -> str:
    """Why a key, or an entry in the list of commands, cannot be used; empty when it can."""
    for gui in pages:
        command = gui._command_handle_from_uuid.get(uuid)
        if command is not None and not command._impl.removed:
            return NOT_NOW if command._impl.props.disabled else ""
    return NOT_THERE


def _is_around_shown(widget: Any) -> bool:
    """Whether all that a widget lies in is shown: folders, and groups of tabs."""
    gui, inside = widget._impl.gui_api, widget._impl.parent_container_id
    while inside != "root":
        try:
            around: Any = gui._resolve_container_handle(inside)
        except KeyError:
            return False  # it was taken away just now
        if isinstance(around, viser.GuiTabHandle):
            around = around._parent
        if isinstance(around, viser.GuiFolderHandle | viser.GuiTabGroupHandle):
            shape: Any = around._impl.props
            if not shape.visible:
                return False
            inside = around._impl.parent_container_id
        else:
            return True  # a dialog, or another panel: it stands in nothing
    return True

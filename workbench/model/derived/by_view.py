"""A cell by one of the views of its scanner on an arm: the arm waits there and scans."""

from dataclasses import replace

import numpy as np

from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import transform
from workbench.model.messages.cells import ViewChoiceText
from workbench.model.robot import ScanPosture
from workbench.model.scan import Scan


def views_of(cell: Cell) -> tuple[ScanPosture, ...]:
    """The views from which the chosen bin is scanned; none where the scanner stands."""
    carrier = cell.scanner.on_arm
    if carrier is None:
        return ()
    return tuple(view for view in carrier.views if view.bin in ("", cell.bin.name))


def views_from(cell: Cell) -> tuple[str, ...]:
    """The names of the views of its bin, from the chosen one on; that is empty where it stands."""
    names = [view.name for view in views_of(cell)] or [""]
    place = names.index(view_name(cell))
    return (*names[place:], *names[:place])


def by_each_view(cell: Cell) -> tuple[Cell, ...]:
    """The cell by each view of its bin, from the chosen one on; alone where the scanner stands."""
    return tuple(with_view(cell, name) for name in views_from(cell))


def view_name(cell: Cell) -> str:
    """The name of the view that is chosen; empty where the scanner stands."""
    return "" if cell.scanner.on_arm is None else cell.scanner.on_arm.view.name


def with_view(cell: Cell, name: str) -> Cell:
    """A cell whose scanner scans from the view of that name.

    Empty: from the view that it has now, or the first one of its bin where that is another bin's.

    Raises:
        InputError: the bin has no such view; the message lists those it has.
    """
    carrier, views = cell.scanner.on_arm, views_of(cell)
    if carrier is None:
        if name:
            raise InputError(ViewChoiceText.STANDS(cell=cell.name))
        return cell
    if not name and carrier.view in views:
        return cell
    found = next((view for view in views if name in ("", view.name)), None)
    if found is None:
        known = [view.name for view in views]
        raise InputError(ViewChoiceText.UNKNOWN(cell=cell.name, name=f"{name:.40}", known=known))
    if found is carrier.view:
        return cell
    others = tuple(view for view in carrier.views if view is not found)
    waits = tuple(
        replace(arm, home=found.q)
        if arm.name == carrier.arm and np.array_equal(arm.home, carrier.view.q)
        else arm
        for arm in cell.arms
    )
    mount = replace(cell.scanner, on_arm=replace(carrier, view=found, other_views=others))
    return replace(cell, scanner=mount, arms=waits)


def scans_by_view(scan: Scan) -> tuple[Scan, ...]:
    """The scan of each view in its own frame, the last one taken last; itself of a single one."""
    if len(scan.views) < 2:
        return (scan,)
    ends = np.cumsum([view.count for view in scan.views])
    found: list[Scan] = []
    for view, end in zip(scan.views, ends, strict=True):
        of = slice(end - view.count, end)
        T = view.T_world_scanner.actInv(scan.T_world_scanner)
        found.append(
            Scan(
                transform(T, scan.points[of]),
                view.T_world_scanner,
                view.name,
                colours=None if scan.colours is None else scan.colours[of],
                joints=scan.joints,
                views=(view,),
            )
        )
    return tuple(found)

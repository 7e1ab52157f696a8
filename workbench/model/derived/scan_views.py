"""A scan that is merged from several views, by each of them: what it saw, from where it saw it."""

import numpy as np

from workbench.model.scan import Scan


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
                scan.points[of] @ T.rotation.T + T.translation,
                view.T_world_scanner,
                view.name,
                colours=None if scan.colours is None else scan.colours[of],
                joints=scan.joints,
                views=(view,),
            )
        )
    return tuple(found)

"""The promises of tools."""

import numpy as np

from workbench.model.cell import Tool
from workbench.plugins.options import Options
from workbench.plugins.tool import ToolKind
from workbench.testing.options import check_options


def check_tool(kind: type[ToolKind], given: Options | None = None) -> Tool:
    """A kind of tool makes a tool that a cell can carry.

    Args:
        kind: the class that is declared.
        given: its options.

    Returns:
        The tool, for what only its maker can check.
    """
    tool = kind().make("tool", check_options(kind.Options, given))
    assert tool.name == "tool", "the name is the one that is given"
    assert tool.body or tool.fingers, "a tool without solids cannot touch anything"
    names = [
        solid.name for solid in (*tool.body, *(each_finger.solid for each_finger in tool.fingers))
    ]
    assert len(set(names)) == len(names), f"solids have different names, not {names}"
    low, high = tool.stroke
    assert 0.0 <= low <= high < 1.0, f"the stroke is in metres, not {tool.stroke}"
    assert not tool.fingers or low < high, "fingers have to move"
    for finger in tool.fingers:
        assert abs(np.linalg.norm(finger.direction) - 1.0) < 1e-6, "directions are unit vectors"
    assert np.linalg.norm(tool.T_flange_tcp.translation) < 2.0, "lengths are in metres"
    return tool

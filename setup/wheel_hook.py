"""Puts into a wheel what numba has compiled here, so that nobody waits for it at the first use.

`workbench compile` makes it; of a tree in which it did not run the wheel holds sources alone.
"""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

COMPILED = (".nbi", ".nbc", ".ready")


class CustomBuildHook(BuildHookInterface[Any]):
    """Called by hatchling, by this name."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the files; an editable installation has them where they are."""
        if version == "editable":
            return
        root = Path(self.root)
        for file in sorted(root.glob("workbench/**/__pycache__/*")):
            if file.suffix in COMPILED:
                build_data["force_include"][str(file)] = file.relative_to(root).as_posix()

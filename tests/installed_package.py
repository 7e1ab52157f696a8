"""A package of somebody else, as if `pip` had installed it: a module and what it declares."""

import sys
from pathlib import Path

import pytest

from workbench.plugins import found


class Plugged:
    """Installs packages for one test; only this process sees them."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch):
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder
        monkeypatch.syspath_prepend(str(folder))
        self._patch = monkeypatch
        self.forget()

    def install(self, package: str, code: str, entries: dict[str, dict[str, str]]) -> None:
        """A package with one module, and its entry points: group -> name -> what in the module."""
        module = package.replace("-", "_")
        (self._folder / f"{module}.py").write_text(code, encoding="utf-8")
        info = self._folder / f"{module}-1.2.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.2\n", encoding="utf-8"
        )
        lines = [
            line
            for group, names in entries.items()
            for line in (
                f"[{group}]",
                *(f"{name} = {module}:{what}" for name, what in names.items()),
            )
        ]
        (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
        self._patch.delitem(sys.modules, module, raising=False)
        self.forget()

    @staticmethod
    def forget() -> None:
        """Look at what is installed again."""
        found._foreign.cache_clear()
        found._load.cache_clear()

"""Python as where no extra is installed, nor a library that only extras need.

A process takes it up whose `PYTHONPATH` names this folder, and so do all that it starts.
"""

import sys
from importlib.abc import MetaPathFinder

LACKING = ("workbench.extras", "asyncua", "mcap", "pymodbus")


class Nothing(MetaPathFinder):
    """Finds none of what lacks."""

    def find_spec(self, fullname, path=None, target=None):
        if fullname in LACKING:
            raise ModuleNotFoundError(f"No module named {fullname!r}", name=fullname)
        return None


sys.meta_path.insert(0, Nothing())

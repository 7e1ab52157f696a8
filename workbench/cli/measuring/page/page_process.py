"""A page that is served by a process of its own, to be measured."""

import re
import subprocess
import sys
import tempfile
from collections.abc import Generator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

from workbench.app.core.people import Role
from workbench.model.errors import LinkError
from workbench.web.access.store import Store
from workbench.web.access.users import Users

PROCESS_NAME = "bench"
END_SECONDS = 30.0


@dataclass(frozen=True, slots=True)
class Served:
    """A page; `token` is for programs, of the same user as the password."""

    url: str
    process: int
    folder: Path
    token: str

    @property
    def memory(self) -> float:
        """Of that process [MB], as the system counts it (proc_pid_status(5), VmRSS)."""
        status = Path(f"/proc/{self.process}/status").read_text()
        found = re.search(r"VmRSS:\s+(\d+) kB", status)
        return int(found[1]) / 1024 if found else 0.0


@contextmanager
def workplace() -> Generator[Path]:
    """An empty folder to serve in, gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="workbench-bench-") as name:
        yield Path(name)


@contextmanager
def serve_page(folder: Path, cell: str, password: str, *words: str) -> Generator[Served]:
    """`workbench serve` in a folder, with one user.

    Args:
        folder: that it works in.
        cell: name or path.
        password: of the user `PROCESS_NAME`.
        words: more that is typed.

    Raises:
        LinkError: it does not serve.
    """
    named = Path(cell).resolve() if len(Path(cell).parts) > 1 else cell
    with closing(Store(folder / "users.sqlite")) as store:
        users = Users(store)
        users.add(PROCESS_NAME, Role.ENGINEER, password)
        token = users.make_token(PROCESS_NAME, "bench")
    typed = ["serve", "--cell", str(named), "--port", "0", "--users", "users.sqlite", *words]
    process = subprocess.Popen(
        [sys.executable, "-m", "workbench", *typed],
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        line = process.stdout.readline() if process.stdout is not None else ""
        found = re.search(r"http://\S+", line)
        if found is None:
            raise LinkError(f"the page was not served: {line.strip() or 'it said nothing'}")
        yield Served(found[0], process.pid, folder, token)
    finally:
        process.terminate()
        try:
            process.communicate(timeout=END_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()

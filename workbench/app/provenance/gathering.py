"""What runs here and now, read from the machine: some tenths of a second, mostly for the files."""

import hashlib
import platform
from collections.abc import Iterator, Mapping
from importlib import metadata
from pathlib import Path

from packaging.utils import canonicalize_name

from workbench import __version__
from workbench.app.provenance.inventory import Distribution, Inventory
from workbench.formats.files.shipped import PACKAGE
from workbench.model.cell import Cell
from workbench.model.digest import digest_of

PROCESSORS = Path("/proc/cpuinfo")

FEATURES = ("avx", "avx2", "fma", "avx512f", "asimd", "sve")
"""What libraries choose their arithmetic by, of what a processor says that it can."""


def inventory(cell: Cell, users: Mapping[str, str]) -> Inventory:
    """What runs here with a cell, for these users (name -> role)."""
    return Inventory(
        workbench=__version__,
        files=files_digest(),
        python=f"{platform.python_implementation()} {platform.python_version()}",
        processor=processor(PROCESSORS),
        system=" ".join((platform.system(), platform.release(), *platform.libc_ver())).strip(),
        distributions=tuple(find_installed()),
        cell=cell.name,
        cell_digest=cell.digest,
        parts={part.name: part.digest for part in cell.parts},
        calibration=digest_of((cell.scanner.T_world_scanner, cell.scanner.calibration)),
        users=dict(users),
    )


def find_installed() -> Iterator[Distribution]:
    """What is installed, in the order of the names."""
    for name, distribution in sorted(by_name().items()):
        listed = distribution.read_text("RECORD")
        record = "" if listed is None else hashlib.sha256(listed.encode()).hexdigest()
        yield Distribution(name, distribution.version, record)


def by_name() -> dict[str, metadata.Distribution]:
    """The installed distributions by name, each once: the one that is imported."""
    found: dict[str, metadata.Distribution] = {}
    for distribution in metadata.distributions():
        # What was removed by half has no name any more, and nothing that could be imported.
        for name in distribution.metadata.get_all("Name") or []:
            found.setdefault(canonicalize_name(name), distribution)
    return found


def files_digest(package: Path = PACKAGE) -> str:
    """SHA-256 over names and content of the workbench's own files, what is compiled left out."""
    whole = hashlib.sha256()
    static = package.parent / "static"
    own = [*package.rglob("*.py"), *(static.rglob("*") if static.is_dir() else ())]
    shipped = package / "shipped"
    own += shipped.rglob("*") if shipped.is_dir() else ()
    for path in sorted({path for path in own if path.is_file()}):
        name, content = path.relative_to(package.parent).as_posix().encode(), path.read_bytes()
        for piece in (name, content):
            whole.update(len(piece).to_bytes(8, "big"))
            whole.update(piece)
    return whole.hexdigest()


def processor(path: Path) -> str:
    """The processor's model and what it can, as `/proc/cpuinfo` has it; else what Python knows."""
    try:
        said = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return platform.processor() or platform.machine()
    fields = (line.partition(":") for line in reversed(said.splitlines()))
    lines = {key.strip().lower(): value.strip() for key, _, value in fields}
    flags = (lines.get("flags") or lines.get("features") or "").split()
    can = [feature for feature in FEATURES if feature in flags]
    return " ".join((lines.get("model name", platform.machine()), *can))

"""Makes one file that installs the workbench where there is no network.

It holds the wheel of the workbench, the wheels of everything that it needs, extras included, in the
versions of `constraints.txt`, and `install.sh`.  It is for machines like this one: the same kind of
processor, and a C library that is no older.

    python setup/bundle.py [--python 3.11 --python 3.12 ...] [--out dist]
"""

import argparse
import hashlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
from collections.abc import Sequence
from pathlib import Path
from sysconfig import get_platform

from packaging.markers import Marker
from packaging.tags import platform_tags

HERE = Path(__file__).resolve().parent
PROJECT = HERE.parent
FOR_DEVELOPERS = {"bench", "docs", "lint", "test"}
"""Extras that a cell has no use for."""

ANY = "python_version >= '3.11'"
ONLY_FOR = {"ur-rtde": "python_version < '3.13'"}
"""Extras that need something of which there is no wheel for each version of Python."""

PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check")


def extras_of(project: Path) -> list[str]:
    """The extras that the bundle holds, sorted."""
    told = tomllib.loads((project / "pyproject.toml").read_text(encoding="utf-8"))
    return sorted(set(told["project"].get("optional-dependencies", {})) - FOR_DEVELOPERS)


def fill(folder: Path, project: Path, constraints: Path, pythons: Sequence[str]) -> str:
    """Put everything into an empty folder; the name of the wheel's distribution and version.

    Raises:
        subprocess.CalledProcessError: the wheel could not be built, or pip found something in no
            wheel for one of these versions of Python; it says what.
    """
    wheels = folder / "wheels"
    build = (sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(wheels))
    subprocess.run(build, cwd=project, check=True, stdout=subprocess.DEVNULL)
    (own,) = wheels.glob("*.whl")
    name, version = own.name.split("-")[:2]
    conditions = {one: ONLY_FOR.get(one, ANY) for one in extras_of(project)}
    lines = [f"{name}\n", *(f"{name}[{one}]; {when}\n" for one, when in conditions.items())]
    (folder / "requirements.txt").write_text("".join(lines), "utf-8")
    places = [word for tag in platform_tags() for word in ("--platform", tag)]
    for python in pythons:
        asked = ("download", "--quiet", "--dest", str(wheels), "--constraint", str(constraints))
        which = ("--only-binary", ":all:", "--implementation", "cp", "--python-version", python)
        # pip asks conditions of the Python that runs it, not of the one that is named.
        which_one = {"python_version": python}
        there = [one for one, when in conditions.items() if Marker(when).evaluate(which_one)]
        wanted = f"{own}[{','.join(there)}]"
        subprocess.run((*PIP, *asked, *which, *places, wanted), check=True)
    shutil.copy(constraints, folder / "constraints.txt")
    shutil.copy(HERE / "install.sh", folder)
    told = sorted(path for path in folder.rglob("*") if path.is_file())
    lines = [f"{_sha256(path)}  {path.relative_to(folder)}\n" for path in told]
    (folder / "SHA256SUMS").write_text("".join(lines), encoding="utf-8")
    return f"{name}-{version}"


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def main() -> int:
    """Make the bundle and say where it is."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--python", action="append", help="3.11 to 3.13 unless told otherwise")
    options.add_argument("--out", type=Path, default=PROJECT / "dist")
    told = options.parse_args()
    told.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=told.out) as made:
        folder = Path(made)
        pythons = told.python or ["3.11", "3.12", "3.13"]
        name = fill(folder, PROJECT, PROJECT / "constraints.txt", pythons)
        bundle = told.out / f"{name}-{get_platform()}.tar"
        partial = bundle.with_suffix(".partial")
        # Wheels are compressed already.
        with tarfile.open(partial, "w") as archive:
            archive.add(folder, arcname=name)
        partial.replace(bundle)
    print(f"{bundle}: {bundle.stat().st_size / 1e6:.0f} MB, SHA-256:")
    print(_sha256(bundle))
    print("where it is to be installed:")
    print(f"tar xf {bundle.name} && sh {name}/install.sh workbench")
    return 0


if __name__ == "__main__":
    sys.exit(main())

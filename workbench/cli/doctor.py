"""`workbench doctor`: what is here, what is missing, and what would install it."""

import shutil
import sys
from pathlib import Path

from workbench import __version__
from workbench.app.provenance.components import components, missing, sbom
from workbench.app.provenance.gathering import PROCESSORS, files_digest, processor
from workbench.app.provenance.libraries import libraries
from workbench.app.runtime.readiness import USES, is_ready
from workbench.cli.arguments.upkeep import Doctor
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.terminal import print_json, print_table
from workbench.formats.files.json_keys import json_text
from workbench.formats.files.whole_files import write_whole

EXTRAS = {
    "opcua": "workbench serve --opcua, workbench opcua",
    "modbus": "workbench serve --modbus",
    "evidence": "workbench evidence --sign, report.pdf",
    "mcap": "workbench session export --mcap",
    "egm": "robot links by Externally Guided Motion",
    "realsense": "the scanner realsense",
    "ur-rtde": "the robot link ur-rtde",
    "cluster": "workbench study --workers",
    "bench": "workbench bench planners --against klampt",
}
"""By name, with what asks for each."""


def doctor(typed: Doctor) -> int:
    """Say what is here."""
    if typed.sbom is not None:
        write_whole(typed.sbom, json_text(typed.sbom, sbom(components(EXTRAS))))
    lacking = missing("")
    extras = {name: missing(name) for name in EXTRAS}
    about = {
        "workbench": f"{__version__} ({files_digest()[:12]})",
        "python": sys.version.partition(" ")[0],
        "processor": processor(PROCESSORS),
        "compiled": "yes" if all(map(is_ready, USES)) else "no: workbench compile",
        "free": f"{shutil.disk_usage(Path.cwd()).free / 2**30:.0f} GB here",
    }
    if typed.json:
        print_json(
            {
                "ok": not lacking,
                **about,
                "missing": lacking,
                "extras": extras,
                "libraries": {library.name: library.is_here for library in libraries()},
            }
        )
    else:
        rows = [(name, text, "") for name, text in about.items()]
        rows.append(("needed", *_report(lacking, "pip install workbench")))
        for name, what in EXTRAS.items():
            state, fix = _report(extras[name], f"pip install 'workbench[{name}]'")
            rows.append((f"for {what}", state, fix))
        for library in libraries():
            state, fix = _report(() if library.is_here else (library.name,), library.installs)
            rows.append((f"for {library.use}", state, fix))
        print_table("Installation", ("what", "is", "what installs it"), rows)
    return NO_PLAN if lacking else SUCCESS


def _report(lacking: tuple[str, ...], fix: str) -> tuple[str, str]:
    return (f"missing: {', '.join(lacking)}", fix) if lacking else ("there", "")

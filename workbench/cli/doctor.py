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
from workbench.plugins.extras import install_command

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
        needs = [("needed", lacking, install_command(""))]
        for name, what in EXTRAS.items():
            needs.append((f"for {what}", extras[name], install_command(name)))
        for library in libraries():
            names = () if library.is_here else (library.name,)
            needs.append((f"for {library.use}", names, library.installs))
        states = [
            (what, f"missing: {', '.join(names)}" if names else "there") for what, names, _ in needs
        ]
        print_table("Installation", ("what", "is"), [*about.items(), *states])
        for what, names, command in needs:
            if names:
                print(f"{what}: {command}")
    return NO_PLAN if lacking else SUCCESS

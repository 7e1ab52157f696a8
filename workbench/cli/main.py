"""From what was typed to a command, and from what it raised to an exit code."""

import importlib
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any

import tyro

from workbench import __version__
from workbench.cli.arguments import bench, cell, part, scanner, session, studies, top
from workbench.cli.exits import BAD_INPUT, FAILURE, INTERRUPTED, NO_LINK, OUTPUT_CLOSED
from workbench.cli.loading import loading
from workbench.model.errors import InputError, LinkError, WorkbenchError
from workbench.plugins.extras import from_extra

DESCRIPTION = """\
Plan, prove, approve and run robotic bin picks.

Exit codes: 0 success, 2 bad input, 3 no plan, no proof or faults, 4 no controller, 1 anything else.

Errors are one line on standard error.
"""


def main(args: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        args: what was typed after `workbench`; None takes it from the process.

    Returns:
        The exit code; see `exits`.
    """
    # Piles fall unseen: otherwise MuJoCo asks a process of its own which library opens windows.
    os.environ.setdefault("MUJOCO_GL", "disable")
    if list(sys.argv[1:] if args is None else args) in (["--version"], ["-V"]):
        print(f"workbench {__version__}")
        return 0
    try:
        with loading():
            typed = parse(args)
        code = run(typed)
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read the output has seen enough: `workbench plan ... | head`.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return OUTPUT_CLOSED
    except InputError as error:
        return _complain(error, BAD_INPUT)
    except LinkError as error:
        return _complain(error, NO_LINK)
    except WorkbenchError as error:
        return _complain(error, FAILURE)


def parse(args: Sequence[str] | None = None) -> top.Arguments:
    """The command that was typed; ends the process after `--help`, and with 2 when it is none."""
    # Without these words tyro looks for some in the source of `typing`: half of what help took.
    kinds = Annotated[top.Arguments, tyro.conf.arg(help="What to do.")]
    return tyro.cli(  # type: ignore[return-value]
        kinds,  # type: ignore[arg-type]
        prog="workbench",
        description=DESCRIPTION,
        args=args,
        config=(
            tyro.conf.DisallowNone,
            tyro.conf.FlagCreatePairsOff,
            tyro.conf.OmitArgPrefixes,
            tyro.conf.PositionalMetavarFromFieldName,
        ),
    )


HOW: Mapping[type, str] = {
    top.Serve: "serving.serve:serve",
    top.Demo: "serving.demo:demo",
    top.Plugins: "authoring.plugins:plugins",
    top.ScanArguments: "picking.look:scan",
    top.Localize: "picking.look:localize",
    top.Calibrate: "calibrating.calibrate:calibrate",
    scanner.ScannerFit: "calibrating.scanner:fit",
    scanner.ScannerDrift: "calibrating.scanner_drift:drift",
    scanner.ScannerTrueness: "calibrating.scanner_checks:trueness",
    scanner.ScannerTouch: "calibrating.scanner_checks:touch",
    top.PlanArguments: "picking.planning:plan",
    top.Explain: "picking.explain:explain",
    top.Prove: "picking.proving:prove",
    top.Verify: "picking.proving:verify",
    top.SendArguments: "serving.send:send",
    top.ControllerArguments: "serving.controller:controller",
    top.RapidCommands: "authoring.rapid:rapid",
    bench.BenchPlanners: "measuring.studies:bench_planners",
    bench.BenchMotion: "measuring.motion:motion",
    bench.BenchBothArms: "measuring.both_arms:both_arms",
    bench.BenchPick: "measuring.studies:bench_pick",
    bench.BenchSoak: "measuring.soak:soak",
    bench.BenchPage: "measuring.page.load:page_load",
    bench.BenchStalls: "measuring.page.stalls:stalls",
    bench.BenchScale: "measuring.scale.command:scale",
    bench.BenchShort: "measuring.short_benchmarks:short",
    studies.StudyLocalization: "measuring.studies:study_localization",
    studies.StudyScans: "measuring.scans:study_scans",
    studies.StudyAbsent: "measuring.seeing.absent:study_absent",
    studies.StudyWrongCad: "measuring.seeing.wrong_cad:study_wrong_cad",
    studies.StudyThreshold: "measuring.studies:study_threshold",
    studies.StudyEmptying: "measuring.emptying:emptying",
    studies.StudyPlacing: "measuring.placing:placing",
    studies.StudyMating: "measuring.mating:study_mating",
    studies.StudyPallets: "measuring.pallets:pallets",
    studies.StudyGrips: "measuring.grips:grips",
    cell.CellNew: "authoring.new_cell:new_cell",
    cell.CellCheck: "authoring.cell_check:check_cell",
    cell.CellShow: "authoring.cell:show_cell",
    cell.CellPose: "authoring.pose:pose",
    cell.CellTool: "authoring.tool:add_tool",
    cell.CellSchema: "authoring.cell:print_schema",
    part.PartImport: "authoring.part:import_part",
    part.PartCheck: "authoring.part_check:check_part",
    part.PartList: "authoring.part:list_parts",
    top.Grasps: "authoring.grasps:grasps",
    top.Import: "authoring.new_cell:import_world",
    session.SessionList: "sessions.inspecting:list_sessions",
    session.SessionShow: "sessions.inspecting:show_session",
    session.SessionVerify: "sessions.inspecting:verify_session",
    session.SessionReplay: "sessions.inspecting:replay_session",
    session.SessionOpen: "serving.open_session:open_session",
    session.SessionExport: "sessions.files:export",
    session.SessionImport: "sessions.files:import_",
    session.SessionCases: "sessions.cases:cases",
    session.SessionPrune: "sessions.files:prune",
    top.UserCommands: "serving.user:user",
    top.StatisticsArguments: "sessions.statistics:print_statistics",
    top.Backup: "serving.backup:backup",
    top.Restore: "serving.backup:restore",
    top.Compile: "compiling:compile_ahead",
    top.Doctor: "doctor:doctor",
}
"""The function in `cli` that carries a command out, loaded when it is typed: that takes a while."""

OF_EXTRAS: Mapping[type, str] = {
    part.PartFromScans: "reconstruction.commands:from_scans",
    studies.StudyModels: "reconstruction.commands:study_models",
    studies.StudyBop: "bop.commands:study_bop",
    top.ExportWorld: "klampt.commands:export_world",
    top.Evidence: "evidence.commands:evidence",
    top.Acceptance: "evidence.commands:write_acceptance",
    top.OpcUaCommands: "opcua.commands:certificates",
}
"""The function of an extra that carries a command out."""


def run(typed: top.Arguments) -> int:
    """Carry a command out and give its exit code; of nested ones the inner one is carried out."""
    is_whole = type(typed) in HOW or type(typed) in OF_EXTRAS
    command: object = typed if is_whole else getattr(typed, "what", None)
    with loading():
        carry_out = _how(type(command))
    return carry_out(command)


def _how(kind: type) -> Callable[[Any], int]:
    if kind in OF_EXTRAS:
        return from_extra(OF_EXTRAS[kind])
    module, _, name = HOW[kind].partition(":")
    return getattr(importlib.import_module(f"workbench.cli.{module}"), name)


def _complain(error: WorkbenchError, code: int) -> int:
    print("workbench: " + " ".join(str(error).split()), file=sys.stderr)
    return code

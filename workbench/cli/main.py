"""From what was typed to a command, and from what it raised to an exit code."""

import os
import sys
from collections.abc import Sequence
from typing import assert_never

import tyro

from workbench.cli.arguments import top as arguments
from workbench.cli.exits import BAD_INPUT, FAILURE, INTERRUPTED, NO_LINK, OUTPUT_CLOSED
from workbench.model.errors import InputError, LinkError, WorkbenchError

DESCRIPTION = """\
Plan, prove, approve and run robotic bin picks.

Exit codes: 0 success, 2 bad input, 3 no plan or proof, 4 no robot controller, 1 anything else.

Errors are one line on standard error.
"""


def main(args: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        args: what was typed after `workbench`; None takes it from the process.

    Returns:
        The exit code; see `exits`.
    """
    typed = parse(args)
    try:
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


def parse(args: Sequence[str] | None = None) -> arguments.Arguments:
    """The command that was typed; ends the process after `--help`, and with 2 when it is none."""
    return tyro.cli(  # type: ignore[return-value]
        arguments.Arguments,  # type: ignore[arg-type]
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


def run(typed: arguments.Arguments) -> int:
    """Carry a command out and give its exit code."""
    match typed:
        case arguments.Serve():
            from workbench.cli.serving.serve import serve

            return serve(typed)
        case arguments.Demo():
            from workbench.cli.serving.demo import demo

            return demo(typed)
        case arguments.Plugins():
            from workbench.cli.authoring.plugins import plugins

            return plugins(typed)
        case arguments.Scan():
            from workbench.cli.picking.look import scan

            return scan(typed)
        case arguments.Localize():
            from workbench.cli.picking.look import localize

            return localize(typed)
        case arguments.Calibrate():
            from workbench.cli.authoring.calibrate import calibrate

            return calibrate(typed)
        case arguments.Scanner():
            from workbench.cli.authoring.scanner import fit

            return fit(typed)
        case arguments.Plan():
            from workbench.cli.picking.planning import plan

            return plan(typed)
        case arguments.Explain():
            from workbench.cli.picking.explain import explain

            return explain(typed)
        case arguments.Prove():
            from workbench.cli.picking.proving import prove

            return prove(typed)
        case arguments.Verify():
            from workbench.cli.picking.proving import verify

            return verify(typed)
        case arguments.Send():
            from workbench.cli.serving.send import send

            return send(typed)
        case arguments.Controller():
            from workbench.cli.serving.controller import controller

            return controller(typed)
        case arguments.ExportWorld():
            from workbench.cli.picking.world import export_world

            return export_world(typed)
        case arguments.Bench():
            from workbench.cli.measuring.studies import bench

            return bench(typed)
        case arguments.Study():
            from workbench.cli.measuring.studies import study

            return study(typed)
        case arguments.CellCommands():
            from workbench.cli.authoring.cell import cell

            return cell(typed)
        case arguments.PartCommands():
            from workbench.cli.authoring.part import part

            return part(typed)
        case arguments.RapidCommands():
            from workbench.cli.authoring.rapid import rapid

            return rapid(typed)
        case arguments.Grasps():
            from workbench.cli.authoring.grasps import grasps

            return grasps(typed)
        case arguments.SessionCommands():
            from workbench.cli.sessions.inspecting import session

            return session(typed)
        case arguments.UserCommands():
            from workbench.cli.serving.user import user

            return user(typed)
        case arguments.Statistics():
            from workbench.cli.sessions.statistics import tell_statistics

            return tell_statistics(typed)
        case arguments.Backup():
            from workbench.cli.serving.backup import backup

            return backup(typed)
        case arguments.Restore():
            from workbench.cli.serving.backup import restore

            return restore(typed)
        case arguments.Import():
            from workbench.cli.authoring.new_cell import import_world

            return import_world(typed)
        case arguments.Compile():
            from workbench.cli.compiling import compile_ahead

            return compile_ahead()
        case _:
            assert_never(typed)


def _complain(error: WorkbenchError, code: int) -> int:
    print("workbench: " + " ".join(str(error).split()), file=sys.stderr)
    return code

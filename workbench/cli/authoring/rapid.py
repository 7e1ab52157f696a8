"""`workbench rapid`: modules in RAPID."""

from dataclasses import asdict

from workbench.cli.arguments.rapid import RapidCommands
from workbench.cli.exits import BAD_INPUT, SUCCESS
from workbench.cli.terminal import print_json
from workbench.model.errors import InputError


def rapid(typed: RapidCommands) -> int:
    """Check modules; one line for each problem."""
    what = typed
    if not what.paths:
        raise InputError("which modules? a folder with a controller.toml, or files")
    try:
        from workbench.formats.rapid.check import check_modules
    except ModuleNotFoundError as error:
        raise InputError("this needs the library lark: pip install 'workbench[rapid]'") from error
    problems = check_modules(what.paths, what.signal)
    if what.json:
        told = [asdict(problem) for problem in problems]
        print_json({"ok": not problems, "problems": told})
    else:
        for problem in problems:
            print(problem)
        print(f"{len(problems)} problems" if problems else "nothing speaks against them")
    return BAD_INPUT if problems else SUCCESS

"""`workbench plugins`: what a cell file can name, where it comes from, and what is broken."""

from dataclasses import asdict

from workbench.cli.arguments import top as arguments
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import print_json, print_table
from workbench.plugins.found import WHAT
from workbench.plugins.found import plugins as found


def plugins(typed: arguments.Plugins) -> int:
    """List them; a broken one is reported and is no failure of this command."""
    all_of_it = sorted(found(), key=lambda plugin: (tuple(WHAT).index(plugin.group), plugin.name))
    if typed.json:
        print_json({"plugins": [asdict(plugin) for plugin in all_of_it]})
        return SUCCESS
    print_table(
        "plug-ins",
        ("what", "name", "from", "version", "state"),
        (
            (
                WHAT[plugin.group],
                plugin.name,
                plugin.package,
                plugin.version,
                plugin.problem or "ready",
            )
            for plugin in all_of_it
        ),
    )
    return SUCCESS

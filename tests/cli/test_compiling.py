"""Compiling ahead: every compiled function of seeing and planning has been called."""

from workbench.cli.main import main


def test_all_that_is_compiled_ahead_still_runs(capsys):
    assert main(["compile"]) == 0
    assert capsys.readouterr().out.startswith("compiled what seeing, planning and grasping need")

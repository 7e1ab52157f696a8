import pytest

from workbench import __version__
from workbench.cli.main import main


@pytest.mark.parametrize("typed", ["--version", "-V"])
def test_the_version_is_printed_alone(typed, capsys):
    assert main([typed]) == 0
    assert capsys.readouterr().out == f"workbench {__version__}\n"

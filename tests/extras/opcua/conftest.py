"""The site that all these tests ask, and patience with servers."""

import pytest
from api_site import heartbeat, people, results, site  # noqa: F401
from waiting import PATIENCE

from workbench.extras.opcua import server


@pytest.fixture(scope="package", autouse=True)
def patient_start():
    """A server reads some thousand nodes before it listens."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(server, "STARTING", PATIENCE)
        yield

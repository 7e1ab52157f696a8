"""The interface against its own description: whatever is sent, the answer is one that it names."""

import json

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, settings
from schemathesis.config import SchemathesisConfig
from waiting import PATIENCE

from workbench.web.api.openapi import openapi

CONFIG = SchemathesisConfig.from_dict({"seed": 7})
STREAM = "/events"
"""It never ends, so it has tests of its own."""

description = schemathesis.openapi.from_dict(json.loads(json.dumps(openapi())), config=CONFIG)


@pytest.fixture
def planned(site):
    """A bench on which there is something of everything, with a plan that was watched."""
    for path, phase in (("/scan", "scanned"), ("/localize", "localized"), ("/plan", "planned")):
        assert site.post(path).status_code == 202
        site.reach(phase)
    assert site.post("/watch", plan=site.bench.state.plan.digest).status_code == 200
    return site


@description.exclude(path=STREAM).parametrize()
@settings(
    max_examples=10,
    deadline=None,
    derandomize=True,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)
@pytest.mark.parametrize("who", ["ada", "vic"])
def test_every_answer_is_one_that_the_description_names(case, planned, who):
    case.call_and_validate(
        base_url=planned.url, headers=planned.token(who), session=planned.session, timeout=PATIENCE
    )
    assert planned.bench.state.number > 1

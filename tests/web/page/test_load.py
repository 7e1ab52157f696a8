"""The load on a page: what goes wrong with it is one error."""

import asyncio

import pytest
from attackers import PASSWORD
from ports import free_port

from workbench.model.errors import LinkError
from workbench.studies.load.crowd import load


def test_a_page_that_is_not_there_is_a_link_error():
    url = f"http://127.0.0.1:{free_port()}"
    with pytest.raises(LinkError, match=url):
        asyncio.run(load(url, "bench", PASSWORD, 1, 1.0))


def test_who_cannot_log_in_is_named(front):
    with pytest.raises(LinkError, match="'nobody' cannot log in"):
        asyncio.run(load(front.url, "nobody", PASSWORD, 1, 1.0))

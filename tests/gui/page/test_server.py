"""The page as a whole, without a browser."""

import urllib.request

import pytest

from workbench.gui.page.server import serve
from workbench.model.errors import InputError


def test_the_page_answers_at_its_url_until_it_is_closed(bench):
    page = serve(bench, port=0)
    try:
        with urllib.request.urlopen(page.url) as answer:
            assert answer.status == 200
            assert b"<html" in answer.read()
    finally:
        page.close()
    with pytest.raises(OSError):
        urllib.request.urlopen(page.url)
    page.close()


def test_two_pages_cannot_share_a_port(bench):
    page = serve(bench, port=0)
    try:
        with pytest.raises(InputError, match="another"):
            serve(bench, port=int(page.url.rpartition(":")[2]))
    finally:
        page.close()

"""Which names are ours, and which pages."""

import pytest

from workbench.plugins.addresses import is_loopback
from workbench.web.http.origins import Origins


@pytest.mark.parametrize(
    ("host", "known"),
    [
        ("127.0.0.1:8080", True),
        ("127.0.0.1", True),
        ("[::1]:8080", True),
        ("10.0.0.7:8080", True),
        ("localhost:8080", True),
        ("LOCALHOST", True),
        ("cell-3:8080", True),
        ("cell-3.factory.example", True),
        ("evil.example:8080", False),
        ("cell-3.evil.example", False),
        ("127.0.0.1.evil.example", False),
        ("evil@127.0.0.1", False),
        ("@127.0.0.1", False),
        (":evil@127.0.0.1", False),
        ("127.0.0.1/evil", False),
        ("[::1%a; script-src *]", False),
        ("[fe80::1%eth0]:8080", True),
        ("127.0.0.1:port", False),
        ("[::1]evil", False),
        ("[::1]evil:80", False),
        ("evil[::1]", False),
        ("::1", False),
        ("127.0.0.1:99999", False),
        ("[::1", False),
        ("0.0.0.0:8080", True),  # an address, if an odd one
        ("", False),
        (None, False),
    ],
)
def test_names_that_we_answer_to(host, known):
    assert Origins("http", "cell-3", ["cell-3.factory.example"]).is_known(host) is known


@pytest.mark.parametrize(
    ("origin", "host", "own"),
    [
        ("http://cell-3:8080", "cell-3:8080", True),
        ("HTTP://CELL-3:8080", "cell-3:8080", True),
        ("https://cell-3:8080", "cell-3:8080", False),
        ("http://cell-3", "cell-3:8080", False),
        ("http://cell-3:8080/", "cell-3:8080", False),
        ("http://evil.example", "cell-3:8080", False),
        ("http://cell-3:8080.evil.example", "cell-3:8080", False),
        ("null", "cell-3:8080", False),
        ("", "cell-3:8080", False),
        (None, "cell-3:8080", False),
    ],
)
def test_pages_that_are_ours(origin, host, own):
    assert Origins("http", "cell-3").is_own(origin, host) is own


@pytest.mark.parametrize(
    ("host", "is_here"),
    [
        ("127.0.0.1", True),
        ("127.9.9.9", True),
        ("::1", True),
        ("::ffff:127.0.0.1", True),
        ("localhost", True),
        ("10.0.0.1", False),
        ("0.0.0.0", False),
        ("cell-3", False),
        (None, False),
    ],
)
def test_what_is_reached_from_this_machine_alone(host, is_here):
    assert is_loopback(host) is is_here

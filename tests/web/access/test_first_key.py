"""The link that lets one browser in while there are no users: once, and from where it may."""

from contextlib import closing

import pytest

from workbench.app.core.people import Role
from workbench.web.access.first_key import FirstKey
from workbench.web.access.store import Store
from workbench.web.access.users import Users

ELSEWHERE = ("192.0.2.7", "::ffff:192.0.2.7", "2001:db8::1", "10.0.0.1", "", None, "nonsense")


@pytest.fixture
def users(tmp_path):
    with closing(Store(tmp_path / "users.sqlite")) as store:
        yield Users(store)


@pytest.mark.parametrize("address", ELSEWHERE)
def test_it_opens_from_this_machine_only_and_no_try_from_elsewhere_uses_it_up(users, address):
    first = FirstKey(users, from_anywhere=False)
    key = first.key
    assert not first.take(key, address)
    assert first.take(key, "127.0.0.1") and not first.take(key, "127.0.0.1")


def test_where_another_address_is_listened_on_it_opens_from_elsewhere_once(users):
    first = FirstKey(users, from_anywhere=True)
    key = first.key
    assert first.take(key, "192.0.2.7") and not first.take(key, "192.0.2.7")


def test_it_opens_no_longer_once_there_is_a_user(users):
    first = FirstKey(users, from_anywhere=False)
    key = first.key
    users.add("Anna", Role.ENGINEER, "seven brown pallets")
    assert not first.take(key, "127.0.0.1")
    assert FirstKey(users, from_anywhere=False).key == ""

"""What others get wrong keeps nobody out of a browser in which they have been."""

import sqlite3
import threading
from contextlib import closing

import pytest
from waiting import PATIENCE, wait_until

from workbench.app.core.people import Role
from workbench.cli.main import main
from workbench.web.access.lockout import (
    MOST_BROWSERS,
    MOST_FAILURES,
    REMEMBERED,
    WHILE,
    LockedOut,
    Lockout,
)
from workbench.web.access.store import Store
from workbench.web.access.users import Users

PASSWORD = "a long password"


class Clock:
    """Time that passes when the test says so."""

    now = 1_000_000.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def store(tmp_path):
    with closing(Store(tmp_path / "users.sqlite")) as opened:
        users = Users(opened)
        users.add("Anna", Role.ENGINEER, PASSWORD)
        users.add("Otto", Role.OPERATOR, PASSWORD)
        yield opened


@pytest.fixture
def lockout(store, clock):
    return Lockout(store, clock)


def locked(lockout, name, address="10.0.0.1", browser=""):
    return isinstance(lockout.begin(address, name, browser), LockedOut)


def wrong(lockout, name, count=MOST_FAILURES):
    for number in range(count):
        lockout.begin(f"10.0.{number}.1", name)


def test_a_clock_that_is_set_back_does_not_make_it_longer(lockout, clock):
    wrong(lockout, "Anna")
    clock.now -= 3600
    assert not locked(lockout, "Anna")
    wrong(lockout, "Anna", MOST_FAILURES - 1)
    assert lockout.begin("10.0.0.1", "Anna").seconds <= WHILE
    clock.now += WHILE
    assert not locked(lockout, "Anna")


def test_a_known_browser_is_not_shut_out_by_others(lockout):
    browser = lockout.remember("Anna")
    wrong(lockout, "Anna")
    assert locked(lockout, "Anna")
    assert locked(lockout, "Anna", browser="made up")
    assert not locked(lockout, "anna", browser=browser)


def test_nor_by_a_crowd_at_its_own_address(lockout):
    browser = lockout.remember("Anna")
    for number in range(MOST_FAILURES):
        lockout.begin("10.0.0.1", f"name {number}")
    assert locked(lockout, "Otto")
    assert not locked(lockout, "Anna", browser=browser)


def test_it_tries_no_more_often_than_others(lockout):
    browser = lockout.remember("Anna")
    for _ in range(MOST_FAILURES):
        assert not locked(lockout, "Anna", browser=browser)
    assert locked(lockout, "Anna", browser=browser)


def test_it_is_known_for_its_own_name_alone(lockout):
    browser = lockout.remember("Otto")
    wrong(lockout, "Anna")
    assert locked(lockout, "Anna", browser=browser)


def test_it_is_known_for_a_while_and_only_the_newest_are(lockout, clock):
    first = lockout.remember("Anna")
    others = []
    for _ in range(MOST_BROWSERS):
        clock.now += 1.0
        others.append(lockout.remember("Anna"))
    wrong(lockout, "Anna")
    assert locked(lockout, "Anna", browser=first)
    assert not locked(lockout, "Anna", browser=others[0])
    clock.now += 180 * 86400.0  # as docs/access.md says
    wrong(lockout, "Anna")
    assert locked(lockout, "Anna", browser=others[-1])


def test_who_logs_in_often_is_known_in_other_browsers_all_the_same(lockout, clock):
    office, panel = lockout.remember("Anna"), lockout.remember("Anna")
    for _ in range(2 * MOST_BROWSERS):
        clock.now += 1.0
        panel = lockout.remember("Anna", panel)
    wrong(lockout, "Anna")
    assert not locked(lockout, "Anna", browser=office)
    assert not locked(lockout, "Anna", browser=panel)


def test_a_browser_may_be_that_of_several_people(lockout):
    copied = lockout.remember("Anna")
    panel = lockout.remember("Otto", copied)
    for name in ("Anna", "Otto"):
        wrong(lockout, name)
        assert not locked(lockout, name, browser=panel)
        assert locked(lockout, name, browser=copied)
    for _ in range(MOST_FAILURES):
        lockout.begin("10.0.0.1", "Otto", panel)
    assert locked(lockout, "Otto", browser=panel)
    assert not locked(lockout, "Anna", browser=panel)


def test_a_browser_is_given_what_it_shows_in_no_case_of_its_own_choice(lockout, clock):
    assert lockout.remember("Anna", "made up") != "made up"
    old = lockout.remember("Anna")
    clock.now += REMEMBERED
    assert lockout.remember("Anna", old) != old


@pytest.mark.parametrize(
    "change",
    [
        lambda users: users.set_password("Anna", "another password"),
        lambda users: users.set_disabled("Anna", True),
        lambda users: users.remove("Anna"),
    ],
)
def test_what_takes_something_from_a_user_ends_that(lockout, store, change):
    browser = lockout.remember("Anna")
    change(Users(store))
    wrong(lockout, "Anna")
    assert locked(lockout, "Anna", browser=browser)


def test_nobody_is_remembered_whom_nobody_knows(lockout, store):
    lockout.remember("Eve")
    assert store.ask("SELECT count(*) FROM browsers") == [(0,)]


def test_somebody_at_the_machine_ends_a_lockout(lockout, store, capsys):
    wrong(lockout, "Anna")
    wrong(lockout, "Otto")
    assert main(["user", "unlock", "Anna", "--users", str(store.path)]) == 0
    assert not locked(lockout, "Anna")
    assert locked(lockout, "Otto")
    assert main(["user", "unlock", "--users", str(store.path)]) == 0
    assert not locked(lockout, "Otto")
    assert f"{MOST_FAILURES} failed logins are forgotten" in capsys.readouterr().out


def test_that_ends_one_in_a_browser_that_is_known_too(lockout, store, capsys):
    anna, otto = lockout.remember("Anna"), lockout.remember("Otto")
    for _ in range(MOST_FAILURES):
        lockout.begin("10.0.0.1", "Anna", anna)
        lockout.begin("10.0.0.1", "Otto", otto)
    assert locked(lockout, "Anna", browser=anna)
    assert main(["user", "unlock", "anna", "--users", str(store.path)]) == 0
    assert not locked(lockout, "Anna", browser=anna)
    assert locked(lockout, "Otto", browser=otto)
    assert f"{MOST_FAILURES} failed logins are forgotten" in capsys.readouterr().out


def test_who_asks_waits_for_no_change(store):
    with closing(sqlite3.connect(store.path, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        changing = threading.Thread(target=Users(store).set_disabled, args=("Otto", True))
        changing.start()
        # It has the store's lock, and waits for the other program's.
        wait_until(store._lock.locked)
        assert Users(store).by_password("Anna", PASSWORD) is not None
        assert changing.is_alive()
        other.execute("ROLLBACK")
        changing.join(PATIENCE)
    assert Users(store).by_password("Otto", PASSWORD) is None


def test_a_file_of_the_version_before_is_taken_along(tmp_path):
    with closing(Store(tmp_path / "users.sqlite")) as opened:
        Users(opened).add("Anna", Role.ENGINEER, PASSWORD)
    with closing(sqlite3.connect(tmp_path / "users.sqlite")) as old, old:
        old.executescript(
            "ALTER TABLE users DROP COLUMN language; DROP TABLE browsers; PRAGMA user_version = 1;"
        )
    with closing(Store(tmp_path / "users.sqlite")) as opened:
        assert [user.name for user in Users(opened).all()] == ["Anna"]
        assert Lockout(opened).remember("Anna")


def test_browsers_that_were_known_before_browsers_were_shared_stay_known(tmp_path, clock):
    with closing(Store(tmp_path / "users.sqlite")) as opened:
        Users(opened).add("Anna", Role.ENGINEER, PASSWORD)
        Users(opened).add("Otto", Role.OPERATOR, PASSWORD)
        panel = Lockout(opened, clock).remember("Anna")
    with closing(sqlite3.connect(tmp_path / "users.sqlite")) as old, old:
        old.executescript(
            "CREATE TABLE before (digest TEXT PRIMARY KEY,"
            " user TEXT NOT NULL REFERENCES users (key)"
            " ON DELETE CASCADE, expires_at REAL NOT NULL) STRICT;"
            "INSERT INTO before SELECT * FROM browsers; DROP TABLE browsers;"
            "ALTER TABLE before RENAME TO browsers;"
            "ALTER TABLE users DROP COLUMN language; PRAGMA user_version = 2;"
        )
    with closing(Store(tmp_path / "users.sqlite")) as opened:
        lockout = Lockout(opened, clock)
        panel = lockout.remember("Otto", panel)
        wrong(lockout, "Anna")
        assert not locked(lockout, "Anna", browser=panel)
        Users(opened).remove("Anna")
        assert opened.ask("SELECT user FROM browsers") == [("otto",)]

"""Users, tokens and logins, in a file that only its owner may read."""

import sqlite3
import subprocess
import sys
from contextlib import closing

import pytest

from workbench.app.core.people import NOBODY, Person, Role
from workbench.model.errors import FileError, InputError
from workbench.web.access import passwords
from workbench.web.access.lockout import MOST_FAILURES, WHILE, LockedOut, Lockout
from workbench.web.access.sessions import Sessions
from workbench.web.access.store import Store
from workbench.web.access.user_backup import add_users, checked_users, kept_users
from workbench.web.access.users import Users, digest_of

NOW = 1_760_000_000.0
PASSWORD = "correct horse battery"


class Clock:
    """Time that stands until it is moved."""

    def __init__(self):
        self.now = NOW

    def __call__(self) -> float:
        return self.now


@pytest.fixture(scope="module")
def kept():
    """A hash of it."""
    return passwords.hash_of(PASSWORD)


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def store(tmp_path, monkeypatch, kept):
    real = passwords.hash_of

    def quick(password):
        return kept if password == PASSWORD else real(password)

    monkeypatch.setattr("workbench.web.access.users.hash_of", quick)
    store = Store(tmp_path / "users.sqlite")
    yield store
    store.close()


@pytest.fixture
def users(store, clock):
    users = Users(store, clock)
    users.add("Anna Weiß", Role.OPERATOR, PASSWORD)
    return users


@pytest.fixture
def sessions(store, clock):
    return Sessions(store, hours=8.0, now=clock)


def test_the_file_is_its_owners_alone(tmp_path, store, users):
    for path in tmp_path.iterdir():
        assert path.stat().st_mode & 0o077 == 0, path


def test_a_file_that_others_may_read_is_made_private(tmp_path):
    path = tmp_path / "open.sqlite"
    path.touch(mode=0o644)
    Store(path).close()
    assert path.stat().st_mode & 0o777 == 0o600


OF_ANOTHER_PROCESS = """
import sys
from pathlib import Path
from workbench.web.access.store import Store
store = Store(Path(sys.argv[1]))
with store.change() as change:
    change.execute("INSERT INTO failures (subject, at) VALUES (?, 0)", [sys.argv[2]])
store.close()
"""


def test_changes_by_other_processes_are_seen_after_this_one_opened_the_file_twice(tmp_path):
    path = tmp_path / "users.sqlite"
    with closing(Store(path)) as served:
        assert served.ask("SELECT subject FROM failures") == []
        Store(path).close()  # as `serve` does for OPC UA
        seen: list[tuple[str]] = []
        for name in ("Ada", "Bob"):
            subprocess.run([sys.executable, "-c", OF_ANOTHER_PROCESS, str(path), name], check=True)
            seen.append((name,))
            assert served.ask("SELECT subject FROM failures") == seen


def test_no_secret_is_in_the_file(tmp_path, store, users, sessions):
    token = users.make_token("Anna Weiß", "gripper")
    cookie = sessions.begin(Person("Anna Weiß", Role.OPERATOR))
    store.close()
    content = b"".join(path.read_bytes() for path in tmp_path.iterdir())
    assert b"argon2id" in content
    for secret in (PASSWORD, token, cookie):
        assert secret.encode() not in content


def test_another_programs_database_is_left_alone(tmp_path):
    path = tmp_path / "other.sqlite"
    with sqlite3.connect(path) as other:
        other.execute("CREATE TABLE theirs (x)")
    other.close()
    with pytest.raises(FileError, match="another program"):
        Store(path)


def test_what_is_no_database_is_named(tmp_path):
    path = tmp_path / "users.sqlite"
    path.write_bytes(b"users = []\n" * 200)
    with pytest.raises(FileError, match="no file of users"):
        Store(path)


def test_a_change_that_sqlite_has_taken_back_itself_is_a_file_error(store):
    """As when the disk is full: there is nothing left to roll back."""
    known = "INSERT OR ROLLBACK INTO users VALUES ('a', 'a', 'viewer', 'x', 0)"
    with pytest.raises(FileError, match="cannot be written"), store.change() as connection:
        connection.execute(known)
        connection.execute(known)
    assert store.ask("SELECT 1 FROM users") == []


def test_the_right_password_and_no_other_lets_in(users):
    assert users.by_password("Anna Weiß", PASSWORD) == Person("Anna Weiß", Role.OPERATOR)
    assert users.by_password("Anna Weiß", PASSWORD + "x") is None
    assert users.by_password("nobody here", PASSWORD) is None


def test_a_name_that_nobody_has_is_answered_after_as_much_work(users, monkeypatch):
    tried = []
    monkeypatch.setattr(
        "workbench.web.access.users.is_right", lambda password, kept: tried.append(kept)
    )
    for name in ("Nobody", "", "x" * 1000):
        assert users.by_password(name, "seven brown pallets") is None
    assert tried == [passwords.NOBODYS] * 3


def test_ways_of_writing_a_name_are_one(users):
    assert users.by_password("ANNA WEISS", PASSWORD) == Person("Anna Weiß", Role.OPERATOR)
    with pytest.raises(InputError, match="already"):
        users.add("anna weiss", Role.VIEWER, PASSWORD)


@pytest.mark.parametrize(
    "name", ["", " ", "a  b", " a", "a\nb", "a\x1b[2J", "x" * 65, NOBODY, "Worker", "robot link"]
)
def test_names_that_cannot_be_anybodys(users, name):
    with pytest.raises(InputError):
        users.add(name, Role.VIEWER, PASSWORD)


@pytest.mark.parametrize("password", ["", "short", "x" * 9, "x" * 201, "\udcff" * 12])
def test_passwords_are_text_of_a_length(users, password):
    with pytest.raises(InputError, match="characters"):
        users.add("Bert", Role.VIEWER, password)


@pytest.mark.parametrize(("name", "shown"), [("Bert", "Bert"), ("\udcff", r"\\udcff")])
def test_an_unknown_name_is_named_with_those_that_are_there(users, name, shown):
    with pytest.raises(InputError, match=f"'{shown}'.*Anna Weiß"):
        users.set_disabled(name, True)


def test_a_disabled_user_is_out_with_password_cookie_and_token(users, sessions):
    token = users.make_token("Anna Weiß", "gripper")
    cookie = sessions.begin(users.by_password("Anna Weiß", PASSWORD))
    assert users.by_token(token) == Person("Anna Weiß", Role.OPERATOR)
    users.set_disabled("Anna Weiß", True)
    assert users.by_password("Anna Weiß", PASSWORD) is None
    assert users.by_token(token) is None
    assert sessions.find(cookie) is None
    users.set_disabled("Anna Weiß", False)
    assert sessions.find(cookie) is None
    assert users.by_token(token) is not None


@pytest.mark.parametrize(
    "change",
    [
        lambda users: users.set_role("Anna Weiß", Role.VIEWER),
        lambda users: users.set_password("Anna Weiß", PASSWORD),
        lambda users: users.remove("Anna Weiß"),
    ],
    ids=["role", "password", "removal"],
)
def test_what_changes_a_user_ends_the_logins(users, sessions, change):
    cookie = sessions.begin(Person("Anna Weiß", Role.OPERATOR))
    digest = sessions.find(cookie).digest
    assert sessions.over({digest}) == frozenset()
    change(users)
    assert sessions.find(cookie) is None
    assert sessions.over({digest}) == {digest}


def test_tokens_are_listed_revoked_and_go_with_their_user(users):
    first = users.make_token("Anna Weiß", "gripper")
    second = users.make_token("Anna Weiß", "line")
    with pytest.raises(InputError, match="already"):
        users.make_token("Anna Weiß", "line")
    assert [token.name for token in users.all()[0].tokens] == ["gripper", "line"]
    users.revoke_token("Anna Weiß", "gripper")
    assert users.by_token(first) is None
    assert users.by_token(second) is not None
    assert users.by_token(second + "x") is None
    with pytest.raises(InputError, match="no token"):
        users.revoke_token("Anna Weiß", "gripper")
    users.remove("Anna Weiß")
    assert users.by_token(second) is None


def test_a_login_lasts_its_hours_and_outlives_the_process(tmp_path, store, users, clock):
    sessions = Sessions(store, hours=8.0, now=clock)
    cookie = sessions.begin(Person("Anna Weiß", Role.OPERATOR))
    again = Store(tmp_path / "users.sqlite")
    later = Sessions(again, hours=8.0, now=clock)
    clock.now += 8 * 3600 - 1
    assert later.find(cookie).person == Person("Anna Weiß", Role.OPERATOR)
    assert later.find(cookie + "x") is None
    clock.now += 1
    assert later.find(cookie) is None
    again.close()


def test_logging_out_ends_one_login(users, sessions):
    one, other = (sessions.begin(Person("Anna Weiß", Role.OPERATOR)) for _ in range(2))
    sessions.end(sessions.find(one).digest)
    assert sessions.find(one) is None
    assert sessions.find(other) is not None


def test_the_first_user_ends_the_login_by_link(store, clock):
    users, sessions = Users(store, clock), Sessions(store, now=clock)
    cookie = sessions.begin(None)
    assert sessions.find(cookie).person == Person(NOBODY, Role.ENGINEER)
    users.add("Bert", Role.ENGINEER, PASSWORD)
    assert sessions.find(cookie) is None
    # A user who was added after the link had been looked at, and before the login begins.
    assert sessions.find(sessions.begin(None)) is None


def test_users_from_a_backup_end_the_login_by_link_too(tmp_path, store, clock, monkeypatch):
    # A backup is given back with hashes as people's are, and no others.
    monkeypatch.setattr("workbench.web.access.users.hash_of", lambda password: passwords.NOBODYS)
    with closing(Store(tmp_path / "kept.sqlite")) as other:
        Users(other, clock).add("Bert", Role.ENGINEER, PASSWORD)
        kept = checked_users(kept_users(other))
    sessions = Sessions(store, now=clock)
    cookie = sessions.begin(None)
    digest = sessions.find(cookie).digest
    add_users(store, kept)
    assert sessions.find(cookie) is None
    assert sessions.over([digest]) == {digest}, "and the windows that are open"


def test_a_login_without_a_user_is_nobodys_once_there_are_users(store, users, sessions):
    # However it came to be there: from a file that another version wrote, say.
    with store.change() as connection:
        connection.execute(
            "INSERT INTO sessions (digest, user, expires_at) VALUES (?, NULL, ?)",
            (digest_of("cookie"), NOW + 1000),
        )
    assert sessions.find("cookie") is None


def test_a_login_does_not_begin_for_who_was_kept_out_or_removed_meanwhile(users, sessions):
    anna = users.by_password("Anna Weiß", PASSWORD)
    users.set_disabled("Anna Weiß", True)
    cookie = sessions.begin(anna)
    users.set_disabled("Anna Weiß", False)
    assert sessions.find(cookie) is None
    users.remove("Anna Weiß")
    assert sessions.find(sessions.begin(anna)) is None


def test_too_many_failures_lock_out_an_address_and_a_name(tmp_path, store, clock):
    lockout = Lockout(store, clock)
    for number in range(MOST_FAILURES):
        assert not isinstance(lockout.begin("10.0.0.1", f"name {number}"), LockedOut)
    assert isinstance(lockout.begin("10.0.0.1", "another"), LockedOut)
    assert not isinstance(lockout.begin("10.0.0.2", "name 0"), LockedOut)
    for number in range(2, MOST_FAILURES):
        lockout.begin(f"10.0.1.{number}", "name 0")
    assert isinstance(lockout.begin("10.0.9.9", "NAME 0"), LockedOut)
    again = Store(tmp_path / "users.sqlite")
    assert isinstance(Lockout(again, clock).begin("10.0.0.1", "another"), LockedOut)
    again.close()
    clock.now += WHILE
    assert not isinstance(lockout.begin("10.0.0.1", "another"), LockedOut)


def test_only_failures_count(store, clock):
    lockout = Lockout(store, clock)
    for _ in range(3 * MOST_FAILURES):
        lockout.note_success(lockout.begin("10.0.0.1", "Anna"))
    assert not isinstance(lockout.begin("10.0.0.1", "Anna"), LockedOut)


def test_a_refused_attempt_does_not_make_it_longer(store, clock):
    lockout = Lockout(store, clock)
    for _ in range(MOST_FAILURES):
        lockout.begin("10.0.0.1", "Anna")
    clock.now += WHILE - 10
    assert lockout.begin("10.0.0.1", "Anna") == LockedOut(10.0)
    clock.now += 10
    assert not isinstance(lockout.begin("10.0.0.1", "Anna"), LockedOut)

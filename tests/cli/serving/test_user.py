"""`workbench user`: who may log in, as people type it."""

import io
import json
import subprocess
import sys

import pytest

from workbench.web.access.store import Store
from workbench.web.access.users import Users

PASSWORD = "correct horse battery"


@pytest.fixture
def file(tmp_path):
    return tmp_path / "users.sqlite"


@pytest.fixture
def user(say, file, monkeypatch):
    def typed(*words, line=PASSWORD):
        monkeypatch.setattr("sys.stdin", io.StringIO(f"{line}\n" if line is not None else ""))
        return say("user", *words, "--users", file)

    return typed


@pytest.fixture
def anna(user):
    said = user("add", "Anna", "--role", "operator", "--stdin")
    assert said.code == 0
    assert said.out.endswith("Anna may log in as operator, by name and password\n")
    return said


@pytest.fixture
def known(file):
    """Who is known with the password, by name and role."""

    def look(name="Anna", password=PASSWORD):
        store = Store(file)
        person = Users(store).by_password(name, password)
        store.close()
        return None if person is None else (person.name, person.role.value)

    return look


def test_a_user_is_added_and_known(anna, known):
    assert known() == ("Anna", "operator")


def test_a_user_is_kept_out_and_let_in_again(anna, user, known):
    assert user("disable", "anna").code == 0
    assert known() is None
    assert user("enable", "Anna").code == 0
    assert known() == ("Anna", "operator")


def test_role_and_password_change(anna, user, known):
    assert user("role", "Anna", "engineer").code == 0
    assert user("password", "Anna", "--stdin", line="another password").code == 0
    assert known() is None
    assert known(password="another password") == ("Anna", "engineer")


def test_a_token_is_printed_once_listed_and_revoked(anna, user, file):
    token = user("token", "Anna", "gripper").out.strip()
    store = Store(file)
    assert Users(store).by_token(token).name == "Anna"
    listed = json.loads(user("list", "--json").out)["users"]
    assert listed[0]["name"] == "Anna"
    assert listed[0]["role"] == "operator"
    assert listed[0]["tokens"][0]["name"] == "gripper"
    assert token not in user("list").out
    assert user("token", "Anna", "gripper", "--revoke").code == 0
    assert Users(store).by_token(token) is None
    store.close()


def test_a_user_is_forgotten(anna, user, known):
    assert user("remove", "Anna").code == 0
    assert known() is None
    assert json.loads(user("list", "--json").out) == {"users": []}


@pytest.mark.parametrize(
    ("words", "line", "problem"),
    [
        (("add", "Bert", "--role", "viewer", "--stdin"), "short", "at least 10 characters"),
        (("add", "Bert", "--role", "viewer", "--stdin"), None, "no line on standard input"),
        (("add", "Bert", "--role", "viewer"), PASSWORD, "no terminal"),
        (("add", "Anna", "--role", "viewer", "--stdin"), PASSWORD, "already"),
        (("add", "worker", "--role", "viewer", "--stdin"), PASSWORD, "stands for no person"),
        (("disable", "Bert"), None, "no user 'Bert' (there is Anna)"),
        (("token", "Anna", "x", "--revoke"), None, "no token 'x'"),
    ],
)
def test_what_cannot_be_is_told_in_one_line(anna, user, words, line, problem):
    said = user(*words, line=line)
    assert said.code == 2
    assert problem in said.problem


def test_a_password_that_is_no_text_is_told_in_one_line(user, say, file, monkeypatch):
    for encoding, errors in (("utf-8", "strict"), ("utf-8", "surrogateescape")):
        typed = io.TextIOWrapper(io.BytesIO(b"\xff" * 12 + b"\n"), encoding, errors)
        monkeypatch.setattr("sys.stdin", typed)
        said = say("user", "add", "Bert", "--role", "viewer", "--stdin", "--users", file)
        assert said.code == 2 and "characters" in said.problem


def test_it_loads_neither_viser_nor_anything_heavy(tmp_path):
    code = (
        "import sys; from workbench.cli.main import main\n"
        f"main(['user', 'list', '--users', {str(tmp_path / 'users.sqlite')!r}])\n"
        "print(sorted({'open3d', 'viser', 'mujoco', 'numba', 'aiohttp'} & set(sys.modules)))"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=600, check=True
    )
    assert ended.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (("--certificate", "page.pem"), "--certificate and --key go together"),
        (("--hours", "0"), "--hours must lie between"),
        (("--port", "65536"), "--port must be a whole number"),
    ],
)
def test_a_front_that_cannot_be_is_told_before_anything_starts(say, words, problem):
    said = say("serve", *words)
    assert said.code == 2
    assert problem in said.problem


def test_only_the_first_user_is_warned_of_the_end_of_the_login_by_link(anna, user):
    assert "Anna is the first user: the printed link logs nobody in any more" in anna.out
    assert "log in by name and password" in anna.out
    assert "No engineer can log in until one is added: Anna is operator." in anna.out
    assert user("add", "Bert", "--role", "viewer", "--stdin").out.count("\n") == 1

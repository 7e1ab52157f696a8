"""`workbench user`: who may log in."""

import getpass
import sys
import time
from contextlib import closing
from typing import assert_never

from workbench.app.core.people import Role
from workbench.cli.arguments.access import (
    UserAdd,
    UserCommands,
    UserDisable,
    UserEnable,
    UserList,
    UserPassword,
    UserRemove,
    UserRole,
    UserToken,
    UserUnlock,
)
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import print_json, print_table
from workbench.model.errors import InputError
from workbench.web.access.lockout import Lockout
from workbench.web.access.store import Store
from workbench.web.access.users import User, Users, key_of


def user(typed: UserCommands) -> int:
    """Carry out a command about users."""
    what = typed.what
    with closing(Store(what.users)) as store:
        users = Users(store)
        match what:
            case UserAdd():
                key_of(what.name)
                if not users.are_there():
                    print(_first_user_warning(what.name, Role(what.role)))
                users.add(what.name, Role(what.role), _password(is_piped=what.stdin))
                print(f"{what.name} may log in as {what.role}, by name and password")
            case UserList():
                _list(what, users.all())
            case UserDisable():
                users.set_disabled(what.name, True)
                print(f"{what.name} is kept out")
            case UserEnable():
                users.set_disabled(what.name, False)
                print(f"{what.name} may log in again")
            case UserPassword():
                users.set_password(what.name, _password(is_piped=what.stdin))
                print(f"{what.name} has a new password and is logged out")
            case UserRole():
                users.set_role(what.name, Role(what.role))
                print(f"{what.name} is {what.role} now and logged out")
            case UserRemove():
                users.remove(what.name)
                print(f"{what.name} is forgotten")
            case UserToken(revoke=True):
                users.revoke_token(what.name, what.called)
                print(f"the token {what.called!r} of {what.name} is worthless now")
            case UserToken():
                print(users.make_token(what.name, what.called))
            case UserUnlock():
                count = Lockout(store).forget(what.name)
                print(f"{count} failed logins are forgotten")
            case _:
                assert_never(what)
    return SUCCESS


def _first_user_warning(name: str, role: Role) -> str:
    """What changes for everybody with the first user, before the password is asked for."""
    warning = (
        f"{name} is the first user: the printed link logs nobody in any more, and who came by it "
        "is logged out. Open the page's address, and log in by name and password."
    )
    if role is not Role.ENGINEER:
        warning += f"\nNo engineer can log in until one is added: {name} is {role}."
    return warning


def _list(typed: UserList, users: tuple[User, ...]) -> None:
    if typed.json:
        print_json(
            {
                "users": [
                    {
                        "name": user.name,
                        "role": user.role,
                        "disabled": user.is_disabled,
                        "tokens": [
                            {"name": token.name, "made_at": token.made_at} for token in user.tokens
                        ],
                    }
                    for user in users
                ]
            }
        )
        return
    rows = [
        (
            user.name,
            user.role,
            "kept out" if user.is_disabled else "",
            ", ".join(f"{token.name} ({_day(token.made_at)})" for token in user.tokens),
        )
        for user in users
    ]
    print_table(f"Users in {typed.users}", ("name", "role", "", "tokens"), rows)


def _day(at: float) -> str:
    return time.strftime("%Y-%m-%d", time.localtime(at))


def _password(*, is_piped: bool) -> str:
    """A new password, typed twice without being shown, or one line of standard input.

    Raises:
        InputError: there is none, or the two differ.
    """
    if is_piped:
        try:
            line = sys.stdin.readline()
        except UnicodeDecodeError:
            raise InputError("--stdin: the line does not consist of characters") from None
        if not line:
            raise InputError("--stdin: there is no line on standard input")
        return line.rstrip("\r\n")
    if not sys.stdin.isatty():
        raise InputError("there is no terminal to ask for the password; see --stdin")
    password = getpass.getpass("New password: ")
    if password != getpass.getpass("Once more: "):
        raise InputError("the two passwords differ")
    return password

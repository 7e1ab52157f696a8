"""What can be typed after `workbench user`; the docstrings are the help."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, subcommand

from workbench.cli.arguments.names import Json, Maybe, UserName, UsersFile

USERS = Path("sessions/users.sqlite")
"""Where users are kept unless stated otherwise."""

RoleName = Literal["viewer", "operator", "engineer"]


@dataclass(frozen=True, slots=True)
class UserAdd:
    """Let somebody log in; the password is asked for. The first user ends the login by link."""

    name: Positional[str]
    """Name of the user, by which the record knows them, too."""
    role: RoleName
    """Viewers look; operators scan, plan, approve and run; engineers edit cell and parts, too."""
    stdin: bool = False
    """Read the password from standard input, one line."""
    users: UsersFile = USERS


@dataclass(frozen=True, slots=True)
class UserList:
    """List the users, their roles and the names of their tokens."""

    users: UsersFile = USERS
    json: Json = False


@dataclass(frozen=True, slots=True)
class UserDisable:
    """Keep somebody out; open pages and tokens stop at once."""

    name: Positional[UserName]
    users: UsersFile = USERS


@dataclass(frozen=True, slots=True)
class UserEnable:
    """Let somebody in again who was kept out."""

    name: Positional[UserName]
    users: UsersFile = USERS


@dataclass(frozen=True, slots=True)
class UserPassword:
    """Give somebody another password, which is asked for, and log them out."""

    name: Positional[UserName]
    stdin: bool = False
    """Read the password from standard input, one line."""
    users: UsersFile = USERS


@dataclass(frozen=True, slots=True)
class UserRole:
    """Give somebody another role and log them out."""

    name: Positional[UserName]
    role: Positional[RoleName]
    """The new role."""
    users: UsersFile = USERS


@dataclass(frozen=True, slots=True)
class UserRemove:
    """Forget somebody, with tokens and logins; the record keeps the name."""

    name: Positional[UserName]
    users: UsersFile = USERS


@dataclass(frozen=True, slots=True)
class UserToken:
    """Make a token for a program that acts for a user, and print it, this once."""

    name: Positional[UserName]
    called: Positional[str]
    """Name of the token, to tell it from others."""
    revoke: bool = False
    """Make the token of that name worthless instead."""
    users: UsersFile = USERS


@dataclass(frozen=True, slots=True)
class UserUnlock:
    """Let logins be tried again after too many have failed: of one name, or of everybody."""

    name: Positional[Maybe[str]] = None
    """Name that was tried too often; every name and address when not given."""
    users: UsersFile = USERS


@dataclass(frozen=True, slots=True)
class UserCommands:
    """Say who may log in to the page, as what, and which programs act for them."""

    what: (
        Annotated[UserAdd, subcommand("add")]
        | Annotated[UserList, subcommand("list")]
        | Annotated[UserDisable, subcommand("disable")]
        | Annotated[UserEnable, subcommand("enable")]
        | Annotated[UserPassword, subcommand("password")]
        | Annotated[UserRole, subcommand("role")]
        | Annotated[UserRemove, subcommand("remove")]
        | Annotated[UserToken, subcommand("token")]
        | Annotated[UserUnlock, subcommand("unlock")]
    )

"""Channels with certificates, and users over them: by a client of another make, and by asyncua."""

import asyncio
import contextlib
from pathlib import Path

import pytest
from asyncua import Client, ua
from asyncua.crypto.security_policies import (
    SecurityPolicyAes128Sha256RsaOaep,
    SecurityPolicyAes256Sha256RsaPss,
    SecurityPolicyBasic256Sha256,
)
from cryptography.hazmat.primitives.serialization import Encoding
from foreign_opcua import foreign
from prepared_bench import Canned
from waiting import PATIENCE

from workbench.app.core.control import ReleaseControl
from workbench.app.core.people import Person, Role
from workbench.app.runtime.bench import Bench
from workbench.extras.opcua.admission import Door, OpcUaLogins, OpcUaOptions
from workbench.extras.opcua.bounds import CALLER, Caller
from workbench.extras.opcua.certificates import (
    MOST_REJECTED,
    REJECTED,
    TRUSTED,
    _reject,
    application_uri,
    make_certificate,
    problem,
    read_certificate,
    trust,
)
from workbench.extras.opcua.server import NAMESPACE, OpcUa
from workbench.journal.journal import Journal
from workbench.model.errors import FileError, InputError
from workbench.web.access.lockout import Lockout
from workbench.web.access.store import Store
from workbench.web.access.users import Users

PLC = Person("plc", Role.OPERATOR)
WORD = "correct horse"
SIGNED, BOTH = ua.MessageSecurityMode.Sign, ua.MessageSecurityMode.SignAndEncrypt
ENCRYPTED = {"policy": "Basic256Sha256", "mode": "SignAndEncrypt"}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The server's certificate, and that of a client."""
    folder = tmp_path_factory.mktemp("certificates")
    make_certificate(folder / "server", ("localhost", "127.0.0.1"), 10)
    make_certificate(folder / "client", ("localhost",), 10)
    return folder


@pytest.fixture(scope="module")
def logins(tmp_path_factory):
    folder = tmp_path_factory.mktemp("users")
    with contextlib.closing(Store(folder / "users.sqlite")) as store:
        users = Users(store)
        for name, role in (("Ada", Role.ENGINEER), ("Bob", Role.OPERATOR), ("Vic", Role.VIEWER)):
            users.add(name, role, WORD)
        yield OpcUaLogins(users, Lockout(store))


@pytest.fixture(scope="module")
def rig(made, results, logins, tmp_path_factory):
    """A bench, and the address of its server, which takes channels with certificates only."""
    folder = tmp_path_factory.mktemp("session")
    bench = Bench(
        results.cell, Journal(folder / "session"), effects=lambda cell, do, now: Canned(results, do)
    )
    options = OpcUaOptions(0, PLC, password="secret", certificates=made / "server", logins=logins)
    server = OpcUa(bench, options)
    yield bench, server.url
    server.close()
    bench.close()


@pytest.fixture
def url(rig, made):
    """The address of a server that trusts our client."""
    trust(made / "server", made / "client" / "server.der")
    return rig[1]


async def secured(url, client: Path, user, policy=SecurityPolicyBasic256Sha256, mode=BOTH):
    """A client of asyncua with a certificate."""
    one = Client(url, timeout=PATIENCE)
    one.application_uri = application_uri(read_certificate(client / "server.der"))
    await one.set_security(policy, client / "server.der", client / "server_key.pem", mode=mode)
    if user[0]:
        one.set_user(user[0])
        one.set_password(user[1])
    return one


def asked(url, *, client: Path, user, **about):
    """Connect, take control, and give back what is answered."""

    async def run():
        async with await secured(url, client, user, **about) as one:
            space = await one.get_namespace_index(NAMESPACE)
            cell = await one.nodes.objects.get_child(f"{space}:Workbench")
            return await cell.call_method(f"{space}:TakeControl")

    return asyncio.run(run())


def test_a_foreign_client_is_refused_until_its_certificate_is_trusted(rig, made, tmp_path):
    bench, url = rig
    own = {
        "pki": str(tmp_path / "pki"),
        "certificate": str(tmp_path / "client.pem"),
        "uri": "urn:foreign:client",
    }
    about = own | ENCRYPTED | {"user": "Ada", "password": WORD}
    refused = foreign(url, **about)
    assert "error" in refused
    assert (made / "server" / REJECTED).is_dir(), refused
    (waiting,) = (made / "server" / REJECTED).glob("*.der")
    assert application_uri(trust(made / "server", waiting)) == "urn:foreign:client"
    assert not list((made / "server" / REJECTED).iterdir())
    found = foreign(url, {"what": "call", "method": "TakeControl"}, {"what": "namespaces"}, **about)
    offered = {(one["policy"], one["mode"]) for one in found["endpoints"]}
    names = ("Basic256Sha256", "Aes128_Sha256_RsaOaep", "Aes256_Sha256_RsaPss")
    assert offered == {(name, mode) for name in names for mode in ("Sign", "SignAndEncrypt")}
    taken, spaces = found["answers"]
    assert (taken["status"], taken["said"][0]) == ("Good", True)
    assert (spaces[2], bench.state.control) == (NAMESPACE, "Ada")


@pytest.mark.parametrize(
    "policy",
    [
        SecurityPolicyBasic256Sha256,
        SecurityPolicyAes128Sha256RsaOaep,
        SecurityPolicyAes256Sha256RsaPss,
    ],
    ids=lambda policy: policy.__name__.removeprefix("SecurityPolicy"),
)
@pytest.mark.parametrize("mode", [SIGNED, BOTH], ids=["signed", "encrypted"])
def test_every_policy_is_spoken(url, made, policy, mode):
    user = ("plc", "secret")
    _, says = asked(url, client=made / "client", policy=policy, mode=mode, user=user)
    assert "control" in says


def test_users_of_the_page_come_over_encrypted_channels_alone(url, rig, made):
    client = made / "client"
    for mode, user in ((SIGNED, ("Bob", WORD)), (BOTH, ("Bob", "wrong")), (BOTH, ("", ""))):
        with pytest.raises(ua.UaError):
            asked(url, client=client, mode=mode, user=user)
    rig[0].do(ReleaseControl(), rig[0].state.control or "Ada")
    assert asked(url, client=client, user=("Bob", WORD))[0]
    assert rig[0].state.control == "Bob"
    done, says = asked(url, client=client, user=("Vic", WORD))
    assert not done and "viewer" in says


def test_without_protection_nobody_comes_in(url):
    async def come():
        client = Client(url, timeout=PATIENCE)
        client.set_user("plc")
        client.set_password("secret")
        async with client:
            raise AssertionError("it came in")

    with pytest.raises(ua.UaError):
        asyncio.run(come())


@pytest.mark.parametrize("is_plain", [False, True])
def test_a_channel_without_protection_is_taken_only_when_that_was_asked_for(made, is_plain):
    options = OpcUaOptions(
        0, PLC, password="secret", certificates=made / "server", is_plain=is_plain
    )
    door = Door(options)
    CALLER.set(Caller("127.0.0.1", ua.MessageSecurityMode.None_))
    assert (door.get_user(None, "plc", "secret") is not None) == is_plain


def test_a_user_who_is_kept_out_calls_nothing_any_more(url, made, logins):
    client = made / "client"

    async def run():
        async with await secured(url, client, ("Ada", WORD)) as one:
            space = await one.get_namespace_index(NAMESPACE)
            cell = await one.nodes.objects.get_child(f"{space}:Workbench")
            await cell.call_method(f"{space}:TakeControl")
            logins.users.set_disabled("Ada", True)
            with pytest.raises(ua.UaStatusCodeError) as caught:
                await cell.call_method(f"{space}:ReleaseControl")
            return caught.value.code

    assert asyncio.run(run()) == ua.StatusCodes.BadUserAccessDenied
    with pytest.raises(ua.UaError):
        asked(url, client=client, user=("Ada", WORD))
    logins.users.set_disabled("Ada", False)


def test_a_message_that_is_too_long_is_cut_off_in_a_secure_channel_too(url, made):
    async def run():
        async with await secured(url, made / "client", ("Bob", WORD)) as one:
            with pytest.raises((ua.UaError, ConnectionError, asyncio.CancelledError)):
                await one.nodes.objects.call_method("0:none", "x" * 2_000_000)

    with contextlib.suppress(ConnectionError):
        asyncio.run(run())
    assert asked(url, client=made / "client", user=("Bob", WORD))


def test_rejected_certificates_are_few_and_the_last_ones(tmp_path):
    for number in range(MOST_REJECTED + 5):
        _reject(tmp_path, b"certificate %d" % number)
    assert len(list(tmp_path.iterdir())) == MOST_REJECTED


def test_what_is_no_certificate_opens_nothing(tmp_path, made):
    assert problem(tmp_path, None) == "it shows no certificate"
    assert problem(tmp_path, b"\x30\x03abc") == "what it shows is no certificate"
    assert problem(tmp_path, b"x" * 100_000) == "it shows no certificate"
    assert not (tmp_path / REJECTED).exists()
    (tmp_path / TRUSTED).mkdir()
    (tmp_path / TRUSTED / "notes.pem").write_text("not a certificate")
    der = read_certificate(made / "client" / "server.der").public_bytes(Encoding.DER)
    assert "is not trusted" in problem(tmp_path, der)
    trust(tmp_path, made / "client" / "server.der")
    assert problem(tmp_path, der) == ""


def test_a_certificate_is_made_once_and_its_key_is_read_by_its_owner_alone(made, tmp_path):
    assert (made / "server" / "server_key.pem").stat().st_mode & 0o777 == 0o600
    with pytest.raises(FileError, match="is there already"):
        make_certificate(made / "server", (), 10)
    with pytest.raises(InputError, match="neither a host name nor an address"):
        make_certificate(tmp_path / "new", ("opc.tcp://here",), 10)
    assert not (tmp_path / "new" / "server_key.pem").exists()


def test_a_key_that_is_none_ends_the_start_with_its_name(site, made, tmp_path):
    (tmp_path / "server.der").write_bytes((made / "server" / "server.der").read_bytes())
    (tmp_path / "server_key.pem").write_text("nothing")
    with pytest.raises(FileError, match="server_key"):
        OpcUa(site.bench, OpcUaOptions(0, PLC, certificates=tmp_path))

"""Logins and certificates of the scanner `http`, against Apache; secrets stay where they are."""

import logging
import shutil
import tempfile
from base64 import b64encode
from dataclasses import replace
from pathlib import Path

import pytest
from apache import PASSWORD, TOKEN, USER, apache, needs_apache
from scanner_calls import SCAN, cell_with, made, taken
from waiting import wait_until

from workbench.app.runtime.work import JOBS
from workbench.devices.scanners.http import HttpScanner
from workbench.devices.scanners.logins import HttpOptions, secret_of
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import write_cloud
from workbench.model.digest import canonical
from workbench.model.errors import FileError, InputError, LinkError
from workbench.plugins.options import options_of
from workbench.testing import check_scanner

VARIABLE = "SCANNER_SECRET_OF_A_TEST"
ENCODED = b64encode(f"{USER}:{PASSWORD}".encode()).decode().rstrip("=")
"""The password as basic sends it."""


@pytest.fixture(scope="module")
def site():
    # Not below pytest's own folder, which nobody but its owner can enter.
    folder = Path(tempfile.mkdtemp())
    try:
        write_cloud(folder / "scan.ply", SCAN)
        with apache(folder, (folder / "scan.ply").read_bytes()) as running:
            yield running
    finally:
        shutil.rmtree(folder)


@pytest.fixture
def secret(tmp_path):
    """A file with a secret for its owner alone."""

    def write(text: str, mode: int = 0o600) -> str:
        (tmp_path / "secret").write_text(text)
        (tmp_path / "secret").chmod(mode)
        return str(tmp_path / "secret")

    return write


def login(kind: str, file: str) -> dict[str, str]:
    user = {} if kind == "bearer" else {"user": USER}
    return {"login": kind, "secret_file": file, **user}


@needs_apache
@pytest.mark.parametrize("kind", ["basic", "digest", "bearer"])
def test_a_login_opens_the_page_and_another_secret_does_not(site, secret, kind):
    right = TOKEN if kind == "bearer" else PASSWORD
    address = f"{site.https}/{kind}/scan.ply"
    trust = {"ca_file": str(site.folder / "ca.pem")}
    options = {**login(kind, secret(f"{right}\n")), **trust}
    assert taken(made(HttpScanner, address, options=options)).digest == SCAN.digest
    with pytest.raises(LinkError, match=rf"refuses the login {kind} \(40[13] ") as told:
        taken(made(HttpScanner, address, options={**options, **login(kind, secret("no secret"))}))
    assert "no secret" not in str(told.value)
    # A bearer's page does not say what it wants.
    asks = "asks for a login" if kind != "bearer" else "refuses the login none"
    with pytest.raises(LinkError, match=asks):
        taken(made(HttpScanner, address, options=trust))


@needs_apache
def test_digest_shows_the_password_to_nobody_also_without_tls(site, secret):
    address = f"{site.plain}/digest/scan.ply"
    scan = taken(made(HttpScanner, address, options=login("digest", secret(PASSWORD))))
    assert scan.digest == SCAN.digest
    wait_until(lambda: 'Digest username=\\"scanner\\"' in site.seen, "the server's log")
    assert PASSWORD not in site.seen


@needs_apache
@pytest.mark.parametrize("kind", ["basic", "bearer"])
def test_a_secret_is_not_sent_where_all_can_read_it(site, secret, kind):
    options = login(kind, secret(TOKEN))
    with pytest.raises(InputError, match="for all to read on the way: give an https address"):
        taken(made(HttpScanner, f"{site.plain}/{kind}/scan.ply?in_the_clear", options=options))
    assert "in_the_clear" not in site.seen


@needs_apache
def test_only_a_certificate_that_is_believed_is_asked(site, secret, tmp_path):
    address = f"{site.https}/basic/scan.ply?believed=0"
    options = login("basic", secret(PASSWORD))
    with pytest.raises(LinkError, match="certificate is not trusted: unable to get local issuer"):
        taken(made(HttpScanner, address, options=options))
    other = {"certificate_sha256": "00" * 32}
    shown = site.fingerprint.replace(":", "").lower()
    with pytest.raises(LinkError, match=f"is {shown}, not that .*; nothing was asked"):
        taken(made(HttpScanner, address, options={**options, **other}))
    byname = site.https.replace("127.0.0.1", "localhost") + "/basic/scan.ply"
    ca = {"ca_file": str(site.folder / "ca.pem")}
    with pytest.raises(LinkError, match="not trusted: Hostname mismatch"):
        taken(made(HttpScanner, f"{byname}?believed=0", options={**options, **ca}))
    (tmp_path / "ca.pem").write_text("no certificate")
    for name, why in (("ca.pem", "holds no certificates"), ("nowhere", "No such file")):
        wrong = {"ca_file": str(tmp_path / name)}
        with pytest.raises(LinkError, match=rf"{name} \(ca_file\).* ?{why}"):
            taken(made(HttpScanner, address, options={**options, **wrong}))
    assert "believed=0" not in site.seen, "a page that was not believed was asked"
    # The one certificate is enough, under any name.
    pinned = {"certificate_sha256": site.fingerprint}
    scan = taken(made(HttpScanner, f"{byname}?believed=1", options={**options, **pinned}))
    assert scan.digest == SCAN.digest
    wait_until(lambda: "believed=1" in site.seen, "the server's log")


@needs_apache
def test_a_page_that_sends_elsewhere_is_not_followed(site):
    with pytest.raises(LinkError, match=r"redirects to other.invalid \(302") as told:
        taken(made(HttpScanner, f"{site.plain}/moved"))
    assert "key=1" not in str(told.value)


@needs_apache
def test_it_keeps_the_promises_of_its_seam(site):
    cell = read_cell("yumi")
    options = {"certificate_sha256": site.fingerprint}
    address = f"{site.https}/open/scan.ply"
    mount = replace(cell.scanner, source="http", address=address, options=options)
    check_scanner(HttpScanner, replace(cell, scanner=mount))


@needs_apache
def test_a_secret_is_in_no_cell_no_digest_no_scan_no_message_and_no_log(
    site, monkeypatch, caplog, tmp_path
):
    caplog.set_level(logging.DEBUG)
    monkeypatch.setenv(VARIABLE, PASSWORD)
    text = f"""
[scanner]
position_mm = [410, 0, 895]
rpy_deg = [180, 0, 90]
field_of_view_deg = 26
source = "http"
address = "{site.https}/basic/scan.ply"
[scanner.options]
login = "basic"
user = "{USER}"
secret_variable = "{VARIABLE}"
certificate_sha256 = "{site.fingerprint}"
"""
    cell = read_cell(cell_with(tmp_path, text))
    told: list[object] = []
    request = {"seed": 0, "parts": 1}
    scan = JOBS["scan"](cell, request, lambda *what: told.append(what), lambda: False)
    assert (scan.points == SCAN.points).all()
    monkeypatch.setenv(VARIABLE, PASSWORD + "!")
    with pytest.raises(LinkError) as refused:
        JOBS["scan"](cell, request, lambda *what: told.append(what), lambda: False)
    values = [str(canonical(cell)), str(canonical(scan)), repr(told)]
    kept = [*values, str(refused.value), caplog.text, text]
    for secret in (PASSWORD, PASSWORD.encode("unicode_escape").decode(), ENCODED):
        assert not any(secret in one for one in kept)
    wait_until(lambda: ENCODED in site.seen, "the secret, which this test looks for")


def test_a_file_that_others_can_read_holds_no_secret(secret):
    for mode in (0o640, 0o604, 0o620):
        file = secret("hush", mode)
        with pytest.raises(LinkError, match=rf"others .*mode {mode:04o}\): `chmod 600") as told:
            secret_of(HttpOptions(login="bearer", secret_file=file))
        assert "hush" not in str(told.value)
    assert secret_of(HttpOptions(login="bearer", secret_file=secret("hush\r\n"))) == "hush"


@pytest.mark.parametrize("text", ["", "\n", "two\nlines\n", "a\0b", "x" * 5000])
def test_what_is_no_secret_is_refused(secret, text, monkeypatch):
    with pytest.raises(LinkError, match=r"\(secret_file\) holds (no secret|more than 4096)"):
        secret_of(HttpOptions(login="bearer", secret_file=secret(text)))


def test_where_there_is_no_secret_it_is_told(tmp_path, monkeypatch):
    monkeypatch.delenv(VARIABLE, raising=False)
    with pytest.raises(LinkError, match=rf"{VARIABLE} \(secret_variable\) is not set"):
        secret_of(HttpOptions(login="bearer", secret_variable=VARIABLE))
    for path, why in ((tmp_path / "none", "No such file"), (tmp_path, "is no file|directory")):
        with pytest.raises(LinkError, match=why):
            secret_of(HttpOptions(login="bearer", secret_file=str(path)))
    (tmp_path / "bytes").write_bytes(b"\xff\xfe")
    (tmp_path / "bytes").chmod(0o600)
    with pytest.raises(LinkError, match="no text in UTF-8"):
        secret_of(HttpOptions(login="bearer", secret_file=str(tmp_path / "bytes")))


SECRET = {"secret_variable": "NAME"}


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"login": "ntlm"}, "login: 'ntlm' is not one of none, basic, digest, bearer"),
        ({"login": "basic", "user": "a"}, "login: basic needs one of secret_file and"),
        (
            {"login": "bearer", "secret_file": "/a", **SECRET},
            "login: bearer needs one of secret_file and secret_variable, 2 are given",
        ),
        ({"login": "digest", **SECRET}, "user: login digest needs a user"),
        ({"login": "bearer", "user": "a", **SECRET}, "user: login bearer has no user"),
        ({"login": "basic", "user": "a:b", **SECRET}, "user: a name without colons"),
        (SECRET, "secret_variable: without login nobody is asked for it"),
        ({"user": "ada"}, "user: without login"),
        ({"login": "bearer", "secret_file": "secret"}, "secret_file: an absolute path"),
        ({"ca_file": "ca.pem"}, "ca_file: an absolute path is expected"),
        ({"certificate_sha256": "12:34"}, "certificate_sha256: 64 hexadecimal digits"),
        ({"certificate_sha256": "a" * 64, "ca_file": "/ca.pem"}, "ca_file: certificate_sha256"),
        ({"password": "hush"}, "password is not known here"),
        ({"login": "bearer", "secret_variable": "hush!"}, "secret_variable: the name of an"),
    ],
)
def test_keys_that_do_not_fit_are_refused_without_their_secrets(options, told):
    with pytest.raises(InputError, match=told) as refused:
        options_of(HttpOptions, options)
    assert "hush" not in str(refused.value)


def test_a_certificate_is_not_looked_for_where_there_is_none():
    options = {"certificate_sha256": "a" * 64}
    with pytest.raises(InputError, match="has no certificate: give an https address"):
        taken(made(HttpScanner, "http://127.0.0.1:9/scan.ply", options=options))


def test_an_address_with_a_password_is_refused_and_not_shown(tmp_path):
    keys = 'source = "http"\naddress = "https://ada:hush@10.0.0.5/scan.ply"\nfield_of_view_deg = 26'
    path = cell_with(
        tmp_path, f"[scanner]\nposition_mm = [410, 0, 895]\nrpy_deg = [180, 0, 90]\n{keys}\n"
    )
    with pytest.raises(FileError, match=r"scanner.address: holds a login") as told:
        read_cell(path)
    assert "hush" not in str(told.value)

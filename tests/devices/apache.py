"""The web server Apache with pages that ask for logins, over TLS: a server of another make."""

import base64
import hashlib
import shutil
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pytest
from ports import free_port
from waiting import wait_until

PROGRAM = shutil.which("apache2") or "/usr/sbin/apache2"
MODULES = Path("/usr/lib/apache2/modules")
needs_apache = pytest.mark.skipif(
    not Path(PROGRAM).exists() or not MODULES.is_dir(), reason="apache2-bin is not installed"
)

USER, PASSWORD, TOKEN, REALM = "scanner", "pass-Wört-7731", "token-4f9a_77.x~", "the scanner's page"
LOADED = (
    *("mpm_event", "authz_core", "authz_user", "authn_core", "authn_file"),
    *("auth_basic", "auth_digest", "alias", "ssl"),
)

SETTINGS = """
ServerRoot {folder}
ServerName 127.0.0.1
PidFile {folder}/pid
ErrorLog {folder}/errors
LogFormat "%U%q %{{Authorization}}i %>s"
TransferLog {folder}/seen
Listen 127.0.0.1:{port}
Listen 127.0.0.1:{plain}
{modules}
User www-data
Group www-data
DocumentRoot {folder}/pages
<Directory {folder}>
    Require all granted
</Directory>
<VirtualHost 127.0.0.1:{port}>
    SSLEngine on
    SSLCertificateFile {folder}/page.pem
    SSLCertificateKeyFile {folder}/page.key
</VirtualHost>
Redirect /moved https://other.invalid/scan.ply?key=1
<Location /basic>
    AuthType Basic
    AuthName "{realm}"
    AuthUserFile {folder}/basic
    Require valid-user
</Location>
<Location /digest>
    AuthType Digest
    AuthName "{realm}"
    AuthDigestProvider file
    AuthUserFile {folder}/digest
    Require valid-user
</Location>
<Location /bearer>
    Require expr %{{HTTP:Authorization}} == 'Bearer {token}'
</Location>
"""


class Site(NamedTuple):
    """A server that runs: its certificate, that of its authority, and what it has seen."""

    folder: Path
    https: str
    plain: str

    @property
    def seen(self) -> str:
        """A line for each request: the page, what was said of the login, the answer."""
        return (self.folder / "seen").read_text()

    @property
    def fingerprint(self) -> str:
        """SHA-256 of the certificate, as OpenSSL prints it."""
        command = ["openssl", "x509", "-in", "page.pem", "-noout", "-sha256", "-fingerprint"]
        ran = subprocess.run(command, cwd=self.folder, check=True, capture_output=True, text=True)
        return ran.stdout.strip().partition("=")[2]


@contextmanager
def apache(folder: Path, content: bytes) -> Iterator[Site]:
    """Serve a scan from `folder`, which others have to be able to enter."""
    folder.chmod(0o755)
    for page in ("open", "basic", "digest", "bearer"):
        (folder / "pages" / page).mkdir(parents=True)
        (folder / "pages" / page / "scan.ply").write_bytes(content)
    shown = base64.b64encode(hashlib.sha1(PASSWORD.encode()).digest()).decode()
    (folder / "basic").write_text(f"{USER}:{{SHA}}{shown}\n")
    hashed = hashlib.md5(f"{USER}:{REALM}:{PASSWORD}".encode()).hexdigest()
    (folder / "digest").write_text(f"{USER}:{REALM}:{hashed}\n")
    certify(folder)
    port, plain = free_port(), free_port()
    modules = "\n".join(f"LoadModule {one}_module {MODULES}/mod_{one}.so" for one in LOADED)
    settings = SETTINGS.format(
        folder=folder, port=port, plain=plain, modules=modules, token=TOKEN, realm=REALM
    )
    (folder / "settings").write_text(settings)
    process = subprocess.Popen(
        [PROGRAM, "-D", "FOREGROUND", "-f", str(folder / "settings")],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )
    try:
        wait_until(lambda: process.poll() is not None or answers(port), "Apache")
        assert process.poll() is None, (folder / "errors").read_text()
        yield Site(folder, f"https://127.0.0.1:{port}", f"http://127.0.0.1:{plain}")
    finally:
        process.terminate()
        process.wait()


def certify(folder: Path) -> None:
    """An authority, and a certificate that it has signed for 127.0.0.1."""

    def openssl(*words: str) -> None:
        subprocess.run(["openssl", *words], cwd=folder, check=True, capture_output=True)

    key = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2")
    # Python 3.13 believes no authority that does not say what it may sign.
    may = ("-subj", "/CN=cell", "-addext", "keyUsage=critical,keyCertSign,cRLSign")
    openssl("req", "-x509", *key, *may, "-keyout", "ca.key", "-out", "ca.pem")
    signed = ("-CA", "ca.pem", "-CAkey", "ca.key", "-addext", "subjectAltName=IP:127.0.0.1")
    name = ("-subj", "/CN=scanner", "-addext", "basicConstraints=critical,CA:FALSE")
    openssl("req", "-x509", *key, *signed, *name, "-keyout", "page.key", "-out", "page.pem")


def answers(port: int) -> bool:
    """Whether somebody listens there."""
    with socket.socket() as link:
        return link.connect_ex(("127.0.0.1", port)) == 0

"""Over TLS: the page, its cookie, its websocket; and certificates that cannot be used."""

import ssl

import pytest
from attackers import PASSWORD, run

from workbench.model.errors import FileError
from workbench.studies.load.raw_browser import raw_browser
from workbench.web.http.listening import TlsCertificate
from workbench.web.page.connections import OVER


def test_the_page_over_tls(certificate, users, start):
    front = start(certificate=certificate)
    assert front.url.startswith("https://127.0.0.1:")
    trusting = ssl.create_default_context(cafile=certificate.certificate)

    async def look():
        async with raw_browser(front.url, trusting) as browser:
            form = {"name": "Otto", "password": PASSWORD}
            async with browser.session.post(
                f"{front.url}/login",
                data=form,
                headers={"Origin": front.url},
                allow_redirects=False,
            ) as answer:
                cookie = answer.headers["Set-Cookie"]
            assert cookie.startswith("__Host-")
            assert "Secure" in cookie
            plain = front.url.replace("https", "http")
            assert await browser.post("/logout", {}, Origin=plain) == 403
            await browser.open()
            await browser.find("press Otto")
            assert await browser.post("/logout", {}) == 303
            assert await browser.close_code() == OVER

    run(look())


def test_old_versions_are_not_spoken(certificate):
    assert certificate.context().minimum_version == ssl.TLSVersion.TLSv1_2


@pytest.mark.parametrize("content", [b"", b"no certificate", None])
def test_a_certificate_that_cannot_be_used_is_named(tmp_path, certificate, content):
    broken = tmp_path / "broken.pem"
    if content is not None:
        broken.write_bytes(content)
    with pytest.raises(FileError, match=r"broken\.pem.*PEM.*expected"):
        TlsCertificate(broken, certificate.key).context()
    with pytest.raises(FileError, match="PEM"):
        TlsCertificate(certificate.certificate, broken).context()

"""Coming in: who gets a login, and who is told what."""

import asyncio
import http.client
import json
import re
import urllib.request

import pytest
from attackers import PASSWORD, cookie_of, run
from waiting import PATIENCE

from workbench import __version__
from workbench.app.core.people import Role
from workbench.model.errors import InputError
from workbench.studies.load.raw_browser import raw_browser
from workbench.web.access.lockout import MOST_FAILURES
from workbench.web.access.store import Store
from workbench.web.access.users import Users


def path_of(link):
    return re.sub(r"^https?://[^/]+", "", link)


def test_without_a_login_there_is_the_login_page_and_nothing_else(front):
    async def look():
        async with raw_browser(front.url) as browser:
            for path in ("/", "/scene/"):
                status, _ = await browser.get(path)
                assert status == 303
            assert (await browser.get("/who"))[0] == 401
            status, text = await browser.get("/login")
            assert status == 200
            assert "Cell tested" in text
            status, text = await browser.get("/healthz")
            assert status == 200
            assert json.loads(text) == {"ok": True, "version": __version__}

    run(look())


def test_name_and_password_lead_to_the_page(front):
    async def look():
        async with raw_browser(front.url) as browser:
            assert await browser.log_in("Otto", PASSWORD) == 303
            status, text = await browser.get("/")
            assert status == 200
            assert "Otto" in text and "operator" in text
            status, text = await browser.get("/scene/")
            assert status == 200
            assert "Viser" in text

    run(look())


def test_the_cookie_is_out_of_reach_for_scripts_and_other_sites(front):
    async def look():
        async with raw_browser(front.url) as browser:
            form = {"name": "Otto", "password": PASSWORD}
            async with browser.session.post(
                f"{front.url}/login",
                data=form,
                headers={"Origin": front.url},
                allow_redirects=False,
            ) as answer:
                cookie = answer.headers["Set-Cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=Strict" in cookie
        assert "Path=/" in cookie
        assert "Secure" not in cookie  # not over TLS here

    run(look())


def test_a_wrong_name_is_answered_as_a_wrong_password(front, said):
    async def look():
        answers = []
        async with raw_browser(front.url) as browser:
            for name, password in (("Otto", "wrong wrong"), ("Nobody", PASSWORD), ("Otto", "")):
                form = {"name": name, "password": password}
                async with browser.session.post(
                    f"{front.url}/login", data=form, headers={"Origin": front.url}
                ) as answer:
                    answers.append((answer.status, (await answer.text()).replace(name, "NAME")))
        assert {status for status, _ in answers} == {401}
        assert len({text for _, text in answers}) == 1

    run(look())
    said("refused login", '"Nobody"', "127.0.0.1", "wrong name or password")


def test_what_is_typed_never_becomes_html(front):
    async def look():
        async with raw_browser(front.url) as browser:
            form = {"name": '"><script>alert(1)</script>', "password": "x"}
            async with browser.session.post(
                f"{front.url}/login", data=form, headers={"Origin": front.url}
            ) as answer:
                text = await answer.text()
        # Our own scripts alone.
        assert text.count("<script") == 2 and "<script>alert" not in text
        assert "&lt;script&gt;" in text

    run(look())


def test_guessing_ends_after_some_tries_and_a_restart_forgets_none(front, start, said):
    async def guess(url):
        async with raw_browser(url) as browser:
            statuses = [
                await browser.log_in("Otto", f"guess number {n}") for n in range(MOST_FAILURES)
            ]
            assert set(statuses) == {401}
            assert await browser.log_in("Otto", PASSWORD) == 429

    async def again(url):
        async with raw_browser(url) as browser:
            assert await browser.log_in("Otto", PASSWORD) == 429
            assert await browser.log_in("Vera", PASSWORD) == 429  # the address is locked, too

    run(guess(front.url))
    front.close()
    run(again(start().url))
    said("refused login", "too many failed")


def test_guesses_made_side_by_side_count_all(front):
    async def guess():
        async with raw_browser(front.url) as browser:
            statuses = await asyncio.gather(
                *(browser.log_in("Otto", f"guess number {n}") for n in range(MOST_FAILURES + 5))
            )
        assert statuses.count(401) == MOST_FAILURES
        assert statuses.count(429) == 5

    run(guess())


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1", ""])
def test_a_form_of_another_site_is_refused(front, said, origin):
    async def look():
        async with raw_browser(front.url) as browser:
            form = {"name": "Otto", "password": PASSWORD}
            assert await browser.post("/login", form, Origin=origin) == 403
            assert await browser.log_in("Otto", PASSWORD) == 303
            assert await browser.post("/logout", {}, Origin=origin) == 403
            assert (await browser.get("/who"))[0] == 200

    run(look())
    said("refused origin", front.url.removeprefix("http://"))


@pytest.mark.parametrize("coding", ["gzip", "deflate", "br", "zstd"])
def test_a_body_that_does_not_decode_is_a_bad_request(front, coding, caplog):
    kind = "application/x-www-form-urlencoded"
    headers = {"Origin": front.url, "Content-Type": kind, "Content-Encoding": coding}

    async def look():
        async with (
            raw_browser(front.url) as browser,
            browser.session.post(f"{front.url}/login", data=b"hello", headers=headers) as answer,
        ):
            assert answer.status in (400, 415)

    run(look())
    assert all(record.exc_info is None for record in caplog.records)


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "", "a@127.0.0.1", "[::1"])
def test_a_name_that_is_not_ours_is_refused(front, said, host):
    async def look():
        async with raw_browser(front.url) as browser:
            assert await browser.log_in("Otto", PASSWORD) == 303
            cookie = await cookie_of(browser)
            assert (await browser.get("/", Host=host, Cookie=cookie))[0] in (400, 421)

    run(look())
    if host:
        said("refused host", host)


@pytest.mark.parametrize(
    "path",
    [
        "/static/../users.sqlite",
        "/static/..%2f..%2fpyproject.toml",
        "/static/%2e%2e/%2e%2e/etc/passwd",
        "/static//etc/passwd",
        "/static/page.css",
        "/static/",
        "/static",
        "/scene/../static/",
        "/scene/index.html",
        "/scene/..%2f..%2fREADME.md",
        "/users.sqlite",
    ],
)
def test_no_path_leads_to_other_files(front, path):
    host, _, port = front.url.removeprefix("http://").partition(":")
    connection = http.client.HTTPConnection(host, int(port), timeout=PATIENCE)
    connection.request("GET", path)
    answer = connection.getresponse()
    assert answer.status in (303, 404)
    assert b"root:" not in answer.read()
    connection.close()


def test_every_answer_tells_the_browser_to_be_strict(front):
    for path in ("/login", "/healthz", "/static/shell.js", "/no/such/page"):
        try:
            answer = urllib.request.urlopen(front.url + path)
        except urllib.error.HTTPError as error:
            answer = error
        with answer:
            headers = answer.headers
        assert headers["X-Content-Type-Options"] == "nosniff", path
        assert headers["Referrer-Policy"] == "same-origin"
        assert headers["Cross-Origin-Opener-Policy"] == "same-origin"
        assert headers["X-Frame-Options"] == "DENY"
        assert headers["Server"] == "workbench"
        policy = headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy
        assert "frame-ancestors 'none'" in policy
        assert "unsafe" not in policy


def test_bodies_that_are_no_form_are_refused(front):
    async def look():
        async with raw_browser(front.url) as browser:
            long = {"name": "Otto", "password": "x" * 10_000}
            assert await browser.post("/login", long) == 413
            for kind in ("application/json", "multipart/form-data; boundary=x"):
                async with browser.session.post(
                    f"{front.url}/login",
                    data=b"{}",
                    headers={"Origin": front.url, "Content-Type": kind},
                ) as answer:
                    assert answer.status == 415

    run(look())


@pytest.mark.parametrize(
    ("charset", "body", "status"),
    [
        ("utf-8", b"name=Otto&password=wrong", 401),
        ("utf-8", b"name=\xff&password=x", 400),
        ("no-such-charset", b"name=Otto&password=x", 415),
        ("unicode_escape", rb"name=\ud800&password=x", 415),
    ],
)
def test_a_form_is_utf_8(front, charset, body, status):
    async def look():
        kind = f"application/x-www-form-urlencoded; charset={charset}"
        headers = {"Origin": front.url, "Content-Type": kind}
        async with (
            raw_browser(front.url) as browser,
            browser.session.post(f"{front.url}/login", data=body, headers=headers) as answer,
        ):
            assert answer.status == status

    run(look())


def test_the_first_link_lets_one_browser_in(start, said):
    front = start()
    path = path_of(front.link)

    async def look():
        async with raw_browser(front.url) as browser, raw_browser(front.url) as other:
            status, text = await browser.get("/first?key=wrong")
            assert status == 401
            status, _ = await browser.get(path)
            assert status == 200
            assert (await browser.get("/who"))[1] == '{"name": "operator", "role": "engineer"}'
            status, text = await other.get(path)
            assert status == 401
            assert "workbench user add" in text
            assert (await other.get("/who"))[0] == 401
            assert (await browser.get("/"))[0] == 200

    run(look())
    said("refused first link", "127.0.0.1")
    assert front.link == front.url


def test_with_users_there_is_no_first_link(front):
    assert front.link == front.url

    async def look():
        async with raw_browser(front.url) as browser:
            assert (await browser.get("/first?key="))[0] == 401
            assert (await browser.get("/first"))[0] == 401

    run(look())


def test_a_user_who_is_added_ends_what_the_link_began(start, file):
    front = start()

    async def look():
        async with raw_browser(front.url) as browser:
            await browser.get(path_of(front.link))
            assert (await browser.get("/who"))[0] == 200
            beside = Store(file)
            Users(beside).add("Edda", Role.ENGINEER, PASSWORD)
            beside.close()
            assert (await browser.get("/who"))[0] == 401

    run(look())


def test_a_busy_port_is_an_input_error_that_names_it(front, start):
    port = int(front.url.rpartition(":")[2])
    with pytest.raises(InputError, match=f"127.0.0.1 port {port}.*--port"):
        start(port=port)


def test_a_restart_keeps_who_is_logged_in(front, start):
    port = int(front.url.rpartition(":")[2])

    async def begin():
        async with raw_browser(front.url) as browser:
            await browser.log_in("Vera", PASSWORD)
            return await cookie_of(browser)

    async def again(url, cookie):
        async with raw_browser(url) as browser:
            assert (await browser.get("/who", Cookie=cookie))[0] == 200

    cookie = run(begin())
    front.close()
    run(again(start(port=port).url, cookie))


def test_from_another_site_the_cookie_comes_a_step_later(front):
    async def look():
        async with raw_browser(front.url) as browser:
            status, text = await browser.get("/", **{"Sec-Fetch-Site": "cross-site"})
            assert status == 200
            assert "refresh" in text

    run(look())

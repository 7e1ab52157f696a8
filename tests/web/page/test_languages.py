"""The language of a page: the user's, the browser's, or what that likes best."""

from attackers import PASSWORD, run

from workbench.studies.load.raw_browser import raw_browser
from workbench.web.page.languages import COOKIE
from workbench.words.catalogs import LANGUAGES

FRENCH, GERMAN = {"Accept-Language": "fr-CH, en;q=0.5"}, {"Accept-Language": "de"}


async def choose(browser, url, language, **headers):
    """Its status, where it leads and the cookie that it sets."""
    async with browser.session.post(
        f"{url}/language",
        data={"language": language},
        headers={"Origin": url, **headers},
        allow_redirects=False,
    ) as answer:
        return answer.status, answer.headers.get("Location"), answer.headers.get("Set-Cookie", "")


def test_before_anybody_has_chosen_it_is_what_the_browser_likes_best(front):
    async def look():
        async with raw_browser(front.url) as browser:
            for headers, language, says in (
                ({}, "en", "Log in"),
                (FRENCH, "fr", "Se connecter"),
                ({"Accept-Language": "nl"}, "en", "Log in"),
            ):
                _, text = await browser.get("/login", **headers)
                assert f'<html lang="{language}">' in text and says in text
            for code, name in LANGUAGES.items():
                assert f'<option value="{code}" lang="{code}">{name}</option>' in text

    run(look())


def test_nobodys_is_kept_with_the_browser_and_a_users_with_the_user(front):
    async def look():
        async with raw_browser(front.url) as browser:
            status, leads, cookie = await choose(browser, front.url, "it")
            assert (status, leads) == (303, "/login")
            assert cookie.startswith(f"{COOKIE}=it;") and "HttpOnly" in cookie
            assert 'lang="it"' in (await browser.get("/login", **FRENCH))[1]
            await browser.log_in("Otto", PASSWORD)
            # Nobody has kept one for Otto: the browser's counts.
            assert '<html lang="it">' in (await browser.get("/"))[1]
            assert (await choose(browser, front.url, "zh"))[:2] == (303, "/")
            _, text = await browser.get("/")
            assert '<html lang="zh">' in text and "停止" in text and 'data-role="operator"' in text
        async with raw_browser(front.url) as browser:
            assert '<html lang="de">' in (await browser.get("/login", **GERMAN))[1]
            await browser.log_in("Otto", PASSWORD)
            assert '<html lang="zh">' in (await browser.get("/", **GERMAN))[1]

    run(look())


def test_there_is_no_other_language_and_no_other_site_chooses(front):
    async def look():
        async with raw_browser(front.url) as browser:
            for wrong in ("xx", "", "../de", "de\r\nX: y", "de" * 200):
                status, _, cookie = await choose(browser, front.url, wrong)
                assert (status, cookie) == (400, "")
            status, _, cookie = await choose(browser, front.url, "de", Origin="http://evil.test")
            assert (status, cookie) == (403, "")

    run(look())


def test_what_went_wrong_at_the_login_is_said_in_it_and_what_was_typed_stays_text(front):
    async def look():
        async with raw_browser(front.url) as browser:
            form = {"name": "<b>Stop</b>", "password": "x"}
            headers = {"Origin": front.url, **GERMAN}
            async with browser.session.post(
                f"{front.url}/login", data=form, headers=headers
            ) as answer:
                text = await answer.text()
        assert "Name oder Passwort ist falsch." in text
        assert 'value="&lt;b&gt;Stop&lt;/b&gt;"' in text

    run(look())

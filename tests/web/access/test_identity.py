"""Who asks, as what is served beside the page learns it: by cookie or by token."""

import pytest
from aiohttp import web
from attackers import PASSWORD, run

from workbench.studies.load.raw_browser import raw_browser
from workbench.web.access.identity import identify


async def me(request):
    person = await identify(request)
    return web.Response(text="nobody" if person is None else f"{person.name} {person.role}")


@pytest.fixture
def front(users, start):
    return start(routes=[web.get("/me", me), web.post("/me", me)])


def bearer(token):
    return {"Authorization": f"Bearer {token}"}


def test_a_login_is_its_person(front):
    async def look():
        async with raw_browser(front.url) as browser:
            assert await browser.get("/me") == (200, "nobody")
            await browser.log_in("Edda", PASSWORD)
            assert await browser.get("/me") == (200, "Edda engineer")

    run(look())


def test_a_token_is_its_user_until_it_is_revoked_or_the_user_disabled(front, users):
    token = users.make_token("Otto", "gripper")

    async def look():
        async with raw_browser(front.url) as program:
            assert await program.get("/me", **bearer(token)) == (200, "Otto operator")
            assert await program.get("/me", authorization=f"bearer {token}") == (
                200,
                "Otto operator",
            )
            assert await program.get("/me", **bearer(token[:-1])) == (200, "nobody")
            assert await program.get("/me", **bearer("")) == (200, "nobody")
            users.set_disabled("Otto", True)
            assert await program.get("/me", **bearer(token)) == (200, "nobody")
            users.set_disabled("Otto", False)
            users.revoke_token("Otto", "gripper")
            assert await program.get("/me", **bearer(token)) == (200, "nobody")

    run(look())


def test_a_wrong_token_is_nobodys_whatever_cookie_comes_with_it(front):
    async def look():
        async with raw_browser(front.url) as browser:
            await browser.log_in("Edda", PASSWORD)
            assert await browser.get("/me", **bearer("wb_wrong")) == (200, "nobody")

    run(look())


def test_with_a_cookie_a_change_has_to_come_from_our_page_with_a_token_from_anywhere(front, users):
    token = users.make_token("Otto", "gripper")

    async def look():
        async with raw_browser(front.url) as browser:
            await browser.log_in("Edda", PASSWORD)
            assert await browser.post("/me", {}) == 200
            assert await browser.post("/me", {}, Origin="http://evil.example") == 403
            async with browser.session.post(f"{front.url}/me", headers=bearer(token)) as answer:
                assert (answer.status, await answer.text()) == (200, "Otto operator")

    run(look())

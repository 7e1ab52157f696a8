"""Viser's page in pieces: nothing of it gets lost, and pieces are kept by browsers."""

import gzip
import re

import pytest
from attackers import PASSWORD, run

from workbench.studies.load.raw_browser import raw_browser
from workbench.web.page.pieces import PATH, PIECES, cut
from workbench.web.page.relay import Upstream
from workbench.web.server import ServerOptions, serve_front

PAGE = '<head><script data-p="{}" data-ss="1">const a=de(d.p);</script></head>'


def names_in(page):
    return re.findall(rf'"{PATH}/(\w+)"', page)


def test_the_pieces_in_their_order_are_the_program():
    program = "".join(chr(35 + number * 7 % 20) for number in range(1003))
    made = cut(PAGE.format(program))
    page = gzip.decompress(made.page).decode()
    pieces = [gzip.decompress(made.pieces[name]).decode() for name in names_in(page)]
    assert len(pieces) == PIECES and "".join(pieces) == program
    assert program not in page and 'data-p=""' in page
    assert page.index("globalThis.wbProgram=") < page.index("de(await globalThis.wbProgram)")


@pytest.mark.parametrize(
    "page",
    [
        "<script>whole()</script>",
        PAGE.format("x") * 2,
        '<script data-p="x" data-ss="1">const a=unpack(d.p);</script>',
    ],
)
def test_a_page_that_is_made_otherwise_stays_whole(page):
    made = cut(page)
    assert gzip.decompress(made.page).decode() == page and not made.pieces


def test_a_browser_gets_a_small_page_and_keeps_its_pieces(front):
    async def look():
        async with raw_browser(front.url) as browser:
            await browser.log_in("Vera", PASSWORD)
            async with browser.session.get(front.url + "/scene/") as answer:
                page, policy = await answer.text(), answer.headers["Content-Security-Policy"]
            assert len(page) < 40_000
            assert f"{front.url}{PATH}/ " in policy
            assert "connect-src 'self'" not in policy
            sizes = []
            for name in names_in(page):
                async with browser.session.get(f"{front.url}{PATH}/{name}") as answer:
                    assert answer.status == 200
                    assert "immutable" in answer.headers["Cache-Control"]
                    assert answer.headers["Cache-Control"].startswith("private")
                    assert answer.headers["Content-Encoding"] == "gzip"
                    sizes.append(answer.content_length)
            assert len(sizes) == PIECES
            # As much as 1 Mbit/s carry in six seconds; more would have to be made smaller.
            assert sum(sizes) < 750_000 and max(sizes) < 1.1 * min(sizes)
            assert (await browser.get(f"{PATH}/{'0' * 32}"))[0] == 404
            plain, text = await browser.get(
                f"{PATH}/{names_in(page)[0]}", **{"Accept-Encoding": "identity"}
            )
            assert plain == 200 and len(text) > sizes[0]

    run(look())


def test_who_is_at_the_login_fetches_the_pieces_and_nothing_else_ahead(front):
    async def look():
        async with raw_browser(front.url) as stranger:
            _, form = await stranger.get("/login")
            ahead = re.search('data-pieces="(.*?)"', form)[1].split()
            assert len(ahead) == PIECES
            program = ""
            for one in ahead:
                status, text = await stranger.get(one)
                assert status == 200
                program += text
            assert (await stranger.get("/scene/"))[0] == 303
            await stranger.log_in("Vera", PASSWORD)
            # They are those of the page: it is whole with what was fetched before.
            _, page = await stranger.get("/scene/")
            assert [f"{PATH}/{name}" for name in names_in(page)] == ahead
            assert len(program) > 500_000 and '"' not in program

    run(look())


def test_the_login_is_there_though_the_page_behind_it_does_not_answer(tmp_path):
    nobody = Upstream("http://127.0.0.1:9", "secret")
    front = serve_front(nobody, tmp_path / "users.sqlite", ServerOptions(port=0), title="alone")
    try:

        async def look():
            async with raw_browser(front.url) as browser:
                status, form = await browser.get("/login")
                assert status == 200 and 'data-pieces=""' in form

        run(look())
    finally:
        front.close()


def test_files_of_ours_go_packed_and_not_again_to_who_has_them(front):
    async def look():
        async with raw_browser(front.url) as browser:
            async with browser.session.get(front.url + "/static/tour.js") as answer:
                assert answer.headers["Content-Encoding"] == "gzip"
                tag, text = answer.headers["ETag"], await answer.text()
                assert answer.content_length < len(text) / 2
            plain = {"Accept-Encoding": "identity"}
            assert await browser.get("/static/tour.js", **plain) == (200, text)
            assert await browser.get("/static/tour.js", **{"If-None-Match": tag}) == (304, "")
            assert (await browser.get("/static/tour.js", **{"If-None-Match": '"x"'}))[0] == 200

    run(look())

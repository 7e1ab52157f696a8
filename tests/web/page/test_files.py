"""Files from browsers: counted, and only as announced."""

import asyncio

import pytest
from attackers import at_the_page, run

from workbench.web.page.uploads import MOST_BYTES, PART_BYTES


async def announce(browser, size, parts=None, transfer="t"):
    await browser.send(
        "FileTransferStartUpload",
        source_component_uuid=browser.widgets["file"],
        transfer_uuid=transfer,
        filename="scan.ply",
        mime_type="",
        part_count=-(-size // PART_BYTES) if parts is None else parts,
        size_bytes=size,
    )


async def send_part(browser, index, content, transfer="t"):
    await browser.send(
        "FileTransferPart",
        source_component_uuid=browser.widgets["file"],
        transfer_uuid=transfer,
        part_index=index,
        content=content,
    )


def test_a_file_arrives_whole(front, scene):
    size = 3 * PART_BYTES + 17

    async def look():
        async with at_the_page(front, "Otto") as browser:
            await browser.find("file")
            reading = asyncio.create_task(browser.close_code())
            await announce(browser, size)
            for index in range(4):
                await send_part(browser, index, b"x" * min(PART_BYTES, size - index * PART_BYTES))
            await asyncio.to_thread(scene.wait, lambda: scene.files)
            reading.cancel()

    run(look())
    assert scene.files == [("scan.ply", size)]


def test_a_viewer_sends_no_files(front, scene, said):
    async def look():
        async with at_the_page(front, "Vera") as browser:
            await browser.find("file")
            await announce(browser, 10)
            await send_part(browser, 0, b"x" * 10)
            await browser.set("number", 1)
            await asyncio.to_thread(scene.wait, lambda: scene.numbers)

    run(look())
    assert scene.files == []
    said("refused message", "FileTransferStartUpload", '"Vera"')


@pytest.mark.parametrize(
    "attack",
    [
        pytest.param([(10, None), (0, 90_000)], id="more than announced"),
        pytest.param([(10, 200)], id="more parts than the size has"),
        pytest.param([(MOST_BYTES + 1, None)], id="too big"),
        pytest.param([(10**12, 100_000)], id="a terabyte"),
        pytest.param([(2 * PART_BYTES, None), (1, PART_BYTES)], id="out of order"),
        pytest.param([(2 * PART_BYTES, None), (0, 5)], id="short part"),
    ],
)
def test_files_that_are_not_as_announced_cut(front, scene, said, attack):
    async def look():
        async with at_the_page(front, "Otto") as browser:
            await browser.find("file")
            size, parts = attack[0]
            await announce(browser, size, parts)
            for index, length in attack[1:]:
                await send_part(browser, index, b"x" * length)
            assert await browser.close_code() == 1008

    run(look())
    said("refused connection", "bytes" if len(attack) < 2 or attack[1][0] == 0 else "part")
    assert scene.files == []

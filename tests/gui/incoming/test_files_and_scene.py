"""Files, clicks, gizmos, pictures and keys: what a browser sends, and what it is told then."""

import asyncio
import logging

import pytest
from few_widgets import run
from raw_browser import PICTURE
from waiting import wait_until

from workbench.gui.incoming.refusals import FILE_REFUSED
from workbench.model.errors import InputError


def file_of(hand, name, transfer="a", button="file"):
    about = {"source_component_uuid": hand.made.id_of(button), "transfer_uuid": transfer}
    shape = {"filename": name, "mime_type": "", "part_count": 1, "size_bytes": 3}
    return about, shape


@pytest.mark.parametrize("name", ["a\0b.stl", "../../x.zip", "..", " ", "ü" * 200, "a\\b", "a\nb"])
def test_a_file_whose_name_is_none_is_told_and_the_next_one_is_taken(hands, caplog, name):
    async def look():
        async with hands() as hand:
            for shown, transfer in ((name, "a"), ("part.stl", "b")):
                about, shape = file_of(hand, shown, transfer)
                await hand.say("FileTransferStartUpload", **about, **shape)
                await hand.say("FileTransferPart", **about, part_index=0, content=b"abc")
            # Otherwise the page would wait for it for ever.
            acknowledged = {"transfer_uuid": "a", "transferred_bytes": 3, "total_bytes": 3}
            await hand.is_told("FileTransferPartAck", **acknowledged)
            await hand.uses("part.stl")

    run(look())
    (told,) = (line for line in caplog.messages if "refused" in line)
    assert "name" in told
    assert "\0" not in told


def test_a_file_for_a_button_that_is_disabled_meanwhile_is_told(hands, caplog):
    async def look():
        async with hands() as hand:
            about, shape = file_of(hand, "part.stl")
            await hand.say("FileTransferStartUpload", **about, **{**shape, "part_count": 2})
            await hand.say("FileTransferPart", **about, part_index=0, content=b"ab")
            await hand.is_told("FileTransferPartAck", transferred_bytes=2)
            hand.made.file.disabled = True
            await hand.say("FileTransferPart", **about, part_index=1, content=b"c")
            note = await hand.is_told("NotificationShowMessage")
            assert note["props"]["body"] == FILE_REFUSED
            assert hand.made.uses == []
            assert not hand.made.client.gui._current_file_upload_states

    run(look())
    assert "it cannot be used now" in caplog.text


TURN, RAY = (1.0, 0.0, 0.0, 0.0), {"ray_origin": (0.0, 0.0, 5.0), "ray_direction": (0.0, 0.0, -1.0)}
CLICK = {"screen_pos": (0.5, 0.5), "modifier": None, "instance_index": None, **RAY}
CLICKED = {"event_type": "click", "screen_pos": [(0.5, 0.5)], "modifier": None, **RAY}
DRAGGED = {"name": "/gizmo", "wxyz": TURN, "position": (1.0, 2.0, 3.0)}


@pytest.mark.parametrize(
    ("kind", "fields"),
    [
        ("TransformControlsUpdate", {**DRAGGED, "wxyz": (0.0, 0.0, 0.0, 0.0)}),
        ("TransformControlsUpdate", {**DRAGGED, "position": (1e9, 0.0, 0.0)}),
        ("TransformControlsUpdate", {**DRAGGED, "name": "/ball"}),
        ("TransformControlsDragStart", {"name": "/hidden"}),
        ("SceneNodeClick", {**CLICK, "name": "/gizmo"}),
        ("SceneNodeClick", {**CLICK, "name": "/nothing"}),
        ("SceneNodeClick", {**CLICK, "name": "/ball", "instance_index": 0}),
        ("SceneNodeClick", {**CLICK, "name": "/ball", "ray_direction": (0.0, 0.0, 0.0)}),
        ("ScenePointer", {**CLICKED, "ray_origin": None}),
        ("ScenePointer", {**CLICKED, "screen_pos": []}),
        ("ScenePointer", {**CLICKED, "event_type": "rect-select"}),
        ("CommandTrigger", {"uuid": "unknown"}),
        ("GuiFormDirty", {"uuid": "unknown"}),
    ],
)
def test_what_the_scene_does_not_offer_is_not_done(hands, caplog, kind, fields):
    async def look():
        async with hands() as hand:
            hand.made.client.scene.add_transform_controls("/hidden").visible = False
            owner = {"owner": "0"} if "name" in fields else {}
            await hand.say(f"{kind}Message", **fields, **owner)
            await hand.set("press", True)
            await hand.uses("press")

    run(look())
    assert "refused value" in caplog.text
    assert "Traceback" not in caplog.text


def test_what_the_scene_offers_is_done(hands, caplog):
    async def look():
        async with hands() as hand:
            await hand.say("TransformControlsUpdateMessage", **DRAGGED, owner="0")
            await hand.uses((1.0, 2.0, 3.0))
            await hand.say("SceneNodeClickMessage", **CLICK, name="/ball", owner="0")
            await hand.uses((1.0, 2.0, 3.0), "ball")
            await hand.say("ScenePointerMessage", **CLICKED)
            await hand.say("CommandTriggerMessage", uuid=hand.made.id_of("key"))
            await asyncio.to_thread(wait_until, lambda: len(hand.made.uses) == 4)
            assert set(hand.made.uses[2:]) == {"scene", "key"}

    run(look())
    assert "refused" not in caplog.text


@pytest.mark.parametrize("payload", [b"", b"no picture", PICTURE])
def test_whatever_comes_for_a_picture_is_never_unpacked(hands, payload):
    async def look():
        async with hands() as hand:
            drawing = asyncio.create_task(asyncio.to_thread(hand.made.client.get_render, 8, 8))
            asked = await hand.is_told("GetRenderRequestMessage")
            await hand.say(
                "GetRenderResponseMessage", payload=payload, render_uuid=asked["render_uuid"]
            )
            assert (await drawing).shape[:2] == (1, 1)

    run(look())


@pytest.mark.parametrize("is_awaited", [False, True])
@pytest.mark.parametrize(
    ("error", "told", "is_logged"),
    [
        (InputError("there is no such arm"), "there is no such arm", False),
        (ValueError("ours"), "ValueError: ours", True),
    ],
)
def test_an_error_of_what_was_asked_for_is_told_where_it_was_asked(
    hands, caplog, capfd, is_awaited, error, told, is_logged
):
    async def look():
        async with hands() as hand:

            def fail(_):
                raise error

            async def fail_too(event):
                fail(event)

            hand.made.press.on_click(fail_too if is_awaited else fail)
            await hand.set("press", True)
            note = await hand.is_told("NotificationShowMessage")
            assert note["props"]["body"] == told

    run(look())
    assert [record.name for record in caplog.records if record.levelno >= logging.ERROR] == (
        ["workbench.gui.incoming.rim"] if is_logged else []
    )
    assert "Traceback" not in "".join(capfd.readouterr())

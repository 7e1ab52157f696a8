"""Somebody at a browser without a screen, who uses what the page offers, and what it does not."""

import asyncio
import contextlib
from dataclasses import dataclass, field

from shown_page import BAR, CHOICE, FILE, FILES, KEY, NO_FRAMES, TEXT, USED, ShownPage
from waiting import PATIENCE

from workbench.app.core.people import Role
from workbench.studies.load.raw_browser import raw_browser

PEOPLE = {"Vera": Role.VIEWER, "Otto": Role.OPERATOR, "Edda": Role.ENGINEER}
PASSWORD = "correct horse battery"

PACE = 1 / 60
"""[s] Between two messages: the front passes on 80 a second, and each shall arrive."""

DROPPED = 12
"""Messages of one browser that the front itself drops; after 20 it ends the browser."""

TURN, PLACE, UP = (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
CAMERA = {"fov": 1.0, "near": 0.01, "far": 1000.0, "image_height": 480, "image_width": 640}
LOOK = {
    "wxyz": TURN,
    "position": (1.0, 1.0, 1.0),
    "look_at": PLACE,
    "up_direction": (0.0, 0.0, 1.0),
}

NO_CAMERAS = (
    *({"wxyz": (0.0,) * 4}, {"fov": 0.0}, {"fov": 4.0}, {"far": -1.0}, {"near": 0.0}),
    *({"up_direction": PLACE}, {"look_at": LOOK["position"]}),
)

OPENED = ("Edit grasps", "Jog", "Show gizmo", "Approve")
"""Buttons behind which there are more controls."""

LEFT_ALONE = ("Release control", "Hand over", "Take control", "Restore it")
"""Not pressed among others: afterwards somebody else is in control."""


@dataclass
class Sitter:
    """Somebody at a browser without a screen."""

    name: str
    browser: object
    page: ShownPage = field(default_factory=ShownPage)
    sent: int = 0
    dropped: int = 0

    async def read(self):
        while (told := await self.browser.read()) is not None:
            for message in told:
                self.page.learn(message)

    async def send(self, kind, **fields):
        await self.browser.send(kind, **fields)
        self.sent += 1
        await asyncio.sleep(PACE)

    async def set(self, uuid, value):
        await self.send("GuiUpdateMessage", uuid=uuid, updates={"value": value})

    async def until(self, condition):
        async with asyncio.timeout(PATIENCE):
            while not condition():
                await asyncio.sleep(0.02)

    async def open_more(self):
        """Open what stands behind some buttons, as far as this person may."""
        await self.until(lambda: self.page.of(TEXT))
        for label in OPENED:
            if (button := self.page.labelled(label)) is not None:
                before = len(self.page.widgets), len(self.page.gizmos)
                await self.set(button, True)
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(1.0):
                        while before == (len(self.page.widgets), len(self.page.gizmos)):
                            await asyncio.sleep(0.02)

    async def confirm(self):
        """Type what anybody may type: when that has come, all that was sent before has."""
        (field,) = (one for one in self.page.of(TEXT) if self.label_of(one) == "Filter")
        asked = f"only {self.sent}"
        await self.set(field, asked)
        return field, asked

    def label_of(self, uuid):
        return self.page.widgets[uuid].shape["label"]

    async def send_wrong(self, rng, others):
        """One message that this person's page does not offer."""
        page, drops = self.page, self.dropped < DROPPED
        is_viewer = PEOPLE[self.name] is Role.VIEWER
        kinds = ["value"] * 12 + ["unknown", "click", "camera", "other"]
        kinds += ["closed"] * 4 + ["frame"] * drops + ["gizmo", "file"] * (drops or not is_viewer)
        kind = rng.choice(kinds)
        self.dropped += kind == "frame" or (is_viewer and kind in ("gizmo", "file"))
        used = page.of(*USED)
        widget = rng.choice([*used, *page.of(CHOICE, TEXT, BAR) * 3])
        if kind == "value":
            await self.set(widget, page.wrong(rng, widget))
        elif kind == "closed":
            shut = [one for one in used if not page.is_offered(one)]
            await self.set(one := rng.choice(shut), page.right(rng, one))
        elif kind == "unknown":
            unknown = rng.choice(("", "no such widget", widget[::-1]))
            await rng.choice((self._press_key, self._press))(unknown)
        elif kind == "other":
            theirs = rng.choice([one for page in others for one in page.of(*USED)])
            await self._press(theirs)
        elif kind == "frame":
            await self.set(widget, rng.choice(NO_FRAMES))
        elif kind == "file":
            await self._send_file(rng, page.of(FILE), used)
        elif kind == "camera":
            broken = rng.choice(NO_CAMERAS)
            await self.send("ViewerCameraMessage", **{**CAMERA, **LOOK, **broken})
        elif kind == "gizmo":
            await self._drag(rng)
        else:
            await self._click(rng)

    async def _press(self, uuid):
        await self.set(uuid, True)

    async def _press_key(self, uuid):
        await self.send("CommandTriggerMessage", uuid=uuid)

    async def _send_file(self, rng, buttons, used):
        name, widget = rng.choice(FILES), rng.choice(buttons or used)
        if rng.random() < 0.4:
            name, widget = "part.stl", rng.choice([one for one in used if one not in buttons])
        transfer = {"source_component_uuid": widget, "transfer_uuid": f"{self.name} {self.sent}"}
        await self.send(
            "FileTransferStartUpload",
            **transfer,
            filename=name,
            mime_type="",
            part_count=1,
            size_bytes=3,
        )
        if PEOPLE[self.name] is not Role.VIEWER:
            await self.send("FileTransferPart", **transfer, part_index=0, content=b"abc")

    async def _drag(self, rng):
        gizmos = list(self.page.gizmos.items())
        if gizmos and rng.random() < 0.6:
            name, owner = rng.choice(gizmos)
            pose = rng.choice(({"wxyz": (0.0,) * 4}, {"wxyz": (90.0,) * 4}))
        else:
            name, owner = rng.choice((("/no such gizmo", ""), ("/cell_gizmo", "999"), ("", "")))
            pose = {}
        about = {"name": name, "owner": owner, "wxyz": TURN, "position": PLACE}
        await self.send("TransformControlsUpdateMessage", **{**about, **pose})

    async def _click(self, rng):
        ray = {"ray_origin": rng.choice((None, PLACE)), "ray_direction": rng.choice((None, PLACE))}
        if rng.random() < 0.5:
            kind = rng.choice(("click", "rect-select"))
            places = [(0.0, 0.0)] * rng.randrange(3)
            await self.send(
                "ScenePointerMessage", event_type=kind, screen_pos=places, modifier=None, **ray
            )
            return
        about = {"name": rng.choice(("/nothing", "/robot", "")), "owner": rng.choice(("", "99"))}
        about |= {"instance_index": rng.choice((None, -1, 10**9)), "screen_pos": (0.0, 0.0)}
        ray = {"ray_origin": PLACE, "ray_direction": PLACE, "modifier": None}
        await self.send("SceneNodeClickMessage", **about, **ray)

    async def use(self, rng):
        """One message that this person's page does offer."""
        page = self.page
        open_ = [one for one in page.of(*USED) if page.is_offered(one)]
        chosen = rng.choice([*open_, *page.of(KEY)])
        kind = page.widgets[chosen].kind
        if kind == KEY:
            await self._press_key(chosen)
        elif kind != FILE and self.label_of(chosen) not in LEFT_ALONE:
            await self.set(chosen, page.right(rng, chosen))


@contextlib.asynccontextmanager
async def sitting(front, name):
    async with raw_browser(front.url) as browser:
        assert await browser.log_in(name, PASSWORD) == 303
        await browser.open()
        sitter = Sitter(name, browser)
        reading = asyncio.create_task(sitter.read())
        try:
            yield sitter
        finally:
            reading.cancel()
            await asyncio.gather(reading, return_exceptions=True)

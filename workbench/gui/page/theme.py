"""The title bar and the colours of the page, light or dark."""

import base64

import viser
from viser import theme

from workbench.formats.files.shipped import find
from workbench.gui.shared.colours import BRAND, rgb_of


class Theme:
    """Settings for viser about the look of the page.

    Concurrency: immutable; any thread.
    """

    def __init__(self, *, is_framed: bool = False) -> None:
        """Read the logos.

        Args:
            is_framed: whether the page stands in a frame that has a title bar already.

        Raises:
            FileError: one is missing.
        """
        self.is_framed = is_framed
        self._titlebar: theme.TitlebarConfig | None = None
        if is_framed:
            return
        self._titlebar = {
            "buttons": (),
            "image": {
                "image_url_light": _inline("logo.svg"),
                "image_url_dark": _inline("logo-dark.svg"),
                "image_alt": "Workbench",
                "href": None,
            },
        }

    def apply(self, gui: viser.GuiApi, *, is_dark: bool) -> None:
        """Dress the page of all browsers or, with the controls of one, of that one."""
        gui.configure_theme(
            titlebar_content=self._titlebar,
            dark_mode=is_dark,
            show_logo=False,
            show_share_button=False,
            brand_color=rgb_of(BRAND),
        )


def _inline(name: str) -> str:
    image = base64.b64encode(find("static", name).read_bytes()).decode()
    return f"data:image/svg+xml;base64,{image}"

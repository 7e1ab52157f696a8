"""What axe-core, a judge of accessibility of others, finds on every tab: nothing serious."""

import shutil
import subprocess
from pathlib import Path

import pytest
from front_page import Window

RUN = """
axe.run(document, {resultTypes: ["violations"]}).then(({violations}) =>
  violations.filter(({impact}) => impact === "serious" || impact === "critical")
    .flatMap(({id, nodes}) => nodes.map(({html}) => `${id}: ${html.slice(0, 200)}`)))
"""


@pytest.fixture(scope="module")
def axe() -> str:
    """Its script."""
    if shutil.which("npm") is None:
        pytest.skip("node is not installed")
    asked = subprocess.run(["npm", "root", "-g"], capture_output=True, text=True, check=True)
    for folder in (Path(__file__).parents[2] / "node_modules", Path(asked.stdout.strip())):
        script = folder / "axe-core" / "axe.min.js"
        if script.is_file():
            return script.read_text(encoding="utf-8") + ";undefined"
    pytest.skip("not installed: npm install -g axe-core")


def test_nothing_serious_is_found_on_any_tab(front, new_context, axe):
    window = Window(new_context())
    page = window.page
    page.goto(front.link)
    window.sees_the_scene()
    page.wait_for_timeout(500)  # names are given a moment after something has changed
    frame = page.locator("#scene").element_handle().content_frame()
    for window_or_frame in (page, frame):
        window_or_frame.evaluate(axe)
    found = {"around": page.evaluate(RUN)}
    for tab in frame.get_by_role("tab").all():
        name = tab.inner_text()
        tab.click()
        page.wait_for_timeout(500)
        found[name] = frame.evaluate(RUN)
    assert len(found) > 8
    assert {name: faults for name, faults in found.items() if faults} == {}

"""The manual in the page: the sections that help leads to, and nothing that leads nowhere."""

import re
import urllib.request

from workbench.web.page.manual import manual_html, read_manual


def test_headings_have_names_and_tables_are_tables():
    made = manual_html("# At the cell\n\n## Stop, faults\n\n| a | b |\n|---|---|\n| 1 | 2 |\n")
    assert '<h1 id="at-the-cell">At the cell</h1>' in made
    assert '<h2 id="stop-faults">Stop, faults</h2>' in made
    assert "<td>2</td>" in made


def test_what_does_not_come_along_stays_as_text():
    made = manual_html(
        "Read [safety](safety.md) and [here](#plan).\n\n![A plan](pictures/p.webp)\n"
    )
    assert "Read safety and" in made and '<a href="#plan">here</a>' in made
    assert "<img" not in made and "webp" not in made


def test_both_of_its_documents_are_one_page():
    made = manual_html("[There](setting_up.md#backup), [here](operator.md#scan).\n")
    assert '<a href="#backup">There</a>' in made and '<a href="#scan">here</a>' in made
    assert '<h2 id="scan">' in read_manual() and '<h2 id="backup">' in read_manual()


def test_html_in_it_is_text():
    assert "<script>" not in manual_html("<script>alert(1)</script>\n\na <b>b</b>")


def test_it_is_served_with_all_its_sections_and_asks_for_nothing_outside(front):
    with urllib.request.urlopen(f"{front.url}/manual") as answer:
        text = answer.read().decode()
        policy = answer.headers["Content-Security-Policy"]
    assert read_manual() in text and '<h2 id="plan">' in text
    assert "script-src 'self'" in policy
    assert not re.search(r'(src|href)="https?:', text)

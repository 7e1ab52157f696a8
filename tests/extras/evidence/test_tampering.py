"""Twenty-odd ways to change evidence, each of which its own script finds with Python alone."""

import hashlib
import re
from pathlib import Path

import pytest
from tampering import OURS, PUBLIC, THEIRS, Opened, anchors_of, verified

from workbench.extras.evidence import packing, verify


def with_other_words(number, body):
    """Somebody else has approved."""
    return body.replace(b'"demo"', b'"eve"')


def an_entry_changed(one):
    one.sql(
        "UPDATE entries SET body = CAST(replace(body, 'demo', 'eve') AS BLOB) WHERE number = 9;"
    )


def an_entry_dropped(one):
    one.sql("DELETE FROM entries WHERE kind = 'WatchPlan';")


def the_last_entry_dropped(one):
    one.sql("DELETE FROM entries WHERE number = (SELECT max(number) FROM entries);")


def the_last_entry_dropped_and_forgotten(one):
    last = one.entries[-1].number
    one.sql(
        f"DELETE FROM entries WHERE number = {last}; UPDATE sqlite_sequence SET seq = {last - 1};"
    )
    one.made_good()


def two_entries_exchanged(one):
    one.sql(
        "UPDATE entries SET number = 900 WHERE number = 12;"
        "UPDATE entries SET number = 12 WHERE number = 13;"
        "UPDATE entries SET number = 13 WHERE number = 900;"
    )
    one.made_good()


def an_entry_appended(one):
    last = one.entries[-1]
    chained = verify.hash_of(last.hash, last.number + 1, last.kind, last.body, ())
    one.sql(
        f"INSERT INTO entries SELECT {last.number + 1}, kind, body, hash, '{chained}'"
        f" FROM entries WHERE number = {last.number};"
    )
    one.made_good()


def the_clock_turned_back(one):
    def earlier(number, body):
        return re.sub(rb'"at":\d+', b'"at":1000000000', body, count=1) if number > 9 else body

    one.chain_anew(earlier)
    one.made_good()


def a_whole_second_chain(one):
    one.chain_anew(with_other_words)
    one.made_good()


def a_whole_second_chain_signed_by_another(one):
    one.chain_anew(with_other_words)
    one.made_good(THEIRS)


def signed_by_another(one):
    one.made_good(THEIRS)


def the_name_of_the_key_exchanged(one):
    words = one.files[packing.SIGNATURE].split()
    theirs = THEIRS.public_key().public_bytes_raw().hex().encode()
    one.files[packing.SIGNATURE] = b"%s\n%s\n" % (theirs, words[1])


def the_signature_removed(one):
    del one.files[packing.SIGNATURE]


def the_signature_of_something_else(one):
    public = OURS.public_key().public_bytes_raw().hex()
    signature = OURS.sign(one.files[packing.MANIFEST]).hex()
    one.files[packing.SIGNATURE] = f"{public}\n{signature}\n".encode()


def the_report_edited(one):
    one.files["report.html"] = one.files["report.html"].replace(b"demo", b"eve")


def the_report_edited_and_stated(one):
    one.files["report.html"] = one.files["report.html"].replace(b"demo", b"eve")
    one.made_good()


def a_printed_report_exchanged(one):
    one.files["report.pdf"] = b"%PDF-1.4 another"


def a_scan_exchanged(one):
    name = next(name for name in one.files if name.startswith(verify.FILES))
    one.files[name] = bytes(len(one.files[name]))


def a_scan_exchanged_and_stated(one):
    a_scan_exchanged(one)
    one.made_good()


def a_scan_dropped(one):
    del one.files[next(name for name in one.files if name.startswith(verify.FILES))]
    one.made_good()


def a_certificate_dropped(one):
    del one.files[next(name for name in one.files if name.startswith("certificates"))]


def a_certificate_exchanged(one):
    name = next(name for name in one.files if name.startswith("certificates"))
    one.files[name] = one.files[name].replace(b'"clearance":', b'"clearance": 1')


def a_message_to_the_robot_changed(one):
    one.files["wire.txt"] = one.files["wire.txt"].replace(b"startL#", b"startR#")


def a_vote_changed(one):
    one.files["approvals.json"] = one.files["approvals.json"].replace(b"demo", b"eve")


def the_script_exchanged(one):
    one.files["verify.py"] = b"print('whole, as it was signed')\n"


def a_file_added(one):
    one.files["session/second.sqlite"] = one.files[verify.JOURNAL]


def another_session_named(one):
    one.stated(session="another")


def another_time_stated(one):
    one.stated(made_at=0.0)


def a_view_in_the_place_of_a_table(one):
    one.sql("ALTER TABLE entries RENAME TO old; CREATE VIEW entries AS SELECT * FROM old;")


def a_journal_that_is_none(one):
    one.files[verify.JOURNAL] = b"SQLite format 3\x00" + bytes(2000)


def a_manifest_that_is_none(one):
    one.files[packing.MANIFEST] = b"[]"


TAMPERINGS = [
    an_entry_changed,
    an_entry_dropped,
    the_last_entry_dropped,
    the_last_entry_dropped_and_forgotten,
    two_entries_exchanged,
    an_entry_appended,
    the_clock_turned_back,
    a_whole_second_chain,
    a_whole_second_chain_signed_by_another,
    signed_by_another,
    the_name_of_the_key_exchanged,
    the_signature_removed,
    the_signature_of_something_else,
    the_report_edited,
    the_report_edited_and_stated,
    a_printed_report_exchanged,
    a_scan_exchanged,
    a_scan_exchanged_and_stated,
    a_scan_dropped,
    a_certificate_dropped,
    a_certificate_exchanged,
    a_message_to_the_robot_changed,
    a_vote_changed,
    the_script_exchanged,
    a_file_added,
    another_session_named,
    another_time_stated,
    a_view_in_the_place_of_a_table,
    a_journal_that_is_none,
    a_manifest_that_is_none,
]


DOCUMENT = Path(__file__).with_name("tamperings.md")
ROWS = re.findall(r"^\| \d+ \| (.+?) \| (.+?) \| (.*?) ?\|$", DOCUMENT.read_text("utf-8"), re.M)
SAID = {name.replace(" ", "_"): (found, signed) for name, found, signed in ROWS}
"""By tampering, what the document says of it: without the right key, and with it."""


def test_the_document_tells_of_each_tampering_once():
    assert list(SAID) == [one.__name__ for one in TAMPERINGS]
    assert len(ROWS) == len(SAID) == 30
    assert {name for name, (_, signed) in SAID.items() if signed} == {
        one.__name__ for one in JOURNALS
    }


def test_an_untouched_bundle_is_whole_also_when_the_workbench_packs_it_again(made, tmp_path):
    assert verified(made, "bundle.zip", "--key", PUBLIC)[0] == 0
    again = Opened(made / "bundle.zip").packed(tmp_path / "again.zip")
    code, said = verified(made, again, "--key", PUBLIC, "--anchors", made / "anchors")
    assert code == 0, said
    assert "whole, as it was signed" in said


def test_a_bundle_of_0_2_0_is_whole_and_each_changed_byte_around_its_files_is_found(made, tmp_path):
    """Written by it from the example session; it does not say how its files are packed."""
    older, anchors = Path(__file__).with_name("of_0_2_0.zip"), tmp_path / "anchors"
    anchors.write_text(anchors_of(Opened(older)))
    code, said = verified(made, older, "--key", PUBLIC, "--anchors", anchors)
    assert (code, "whole, as it was signed" in said) == (0, True), said
    content, path = older.read_bytes(), tmp_path / "bundle.zip"
    directory = content.index(b"PK\1\2")
    for place in (*range(30), *range(directory, len(content), 17)):
        path.write_bytes(content[:place] + bytes([content[place] ^ 4]) + content[place + 1 :])
        assert verify.problems_of(path, bytes.fromhex(PUBLIC), None)[0], place


@pytest.mark.parametrize("tamper", TAMPERINGS, ids=lambda one: one.__name__)
def test_every_tampering_is_found(made, tmp_path, tamper):
    one = Opened(made / "bundle.zip")
    tamper(one)
    code, said = verified(made, one.packed(tmp_path / "bundle.zip"), "--key", PUBLIC)
    assert code == 1, said
    assert "CHANGED" in said and SAID[tamper.__name__][0] in said


JOURNALS = [
    an_entry_changed,
    an_entry_dropped,
    two_entries_exchanged,
    a_scan_exchanged_and_stated,
    a_scan_dropped,
    a_message_to_the_robot_changed,
    a_vote_changed,
]


@pytest.mark.parametrize("tamper", JOURNALS, ids=lambda one: one.__name__)
def test_what_contradicts_the_journal_is_found_whoever_signs_it(made, tmp_path, tamper):
    one = Opened(made / "bundle.zip")
    tamper(one)
    kept = {name: one.files[name] for name in verify.derive_files([])}
    one.made_good()
    one.files |= kept if tamper in JOURNALS[-2:] else {}
    files = one.manifest["files"]
    for name in verify.derive_files([]):
        content = one.files[name]
        files[name] = {"size": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    one.stated(files=files)
    one.repacked()
    one.signed(OURS)
    code, said = verified(made, one.packed(tmp_path / "bundle.zip"), "--key", PUBLIC)
    assert code == 1, said
    assert "signed with another key" not in said and SAID[tamper.__name__][1] in said


def test_a_journal_rewritten_as_a_whole_before_it_was_signed_is_found_by_anchors(made, tmp_path):
    one = Opened(made / "bundle.zip")
    one.chain_anew(with_other_words)
    one.made_good(OURS)
    path = one.packed(tmp_path / "bundle.zip")
    assert verified(made, path, "--key", PUBLIC)[0] == 0
    code, said = verified(made, path, "--key", PUBLIC, "--anchors", made / "anchors")
    assert (code, "not the one kept elsewhere" in said) == (1, True)


def test_a_session_that_was_cut_short_before_it_was_signed_is_found_by_anchors(made, tmp_path):
    one = Opened(made / "bundle.zip")
    one.sql("DELETE FROM entries WHERE number > 5; UPDATE sqlite_sequence SET seq = 5;")
    one.sql("DELETE FROM entry_files WHERE entry > 5;")
    one.made_good(OURS)
    path = one.packed(tmp_path / "bundle.zip")
    assert verified(made, path, "--key", PUBLIC)[0] == 0
    code, said = verified(made, path, "--key", PUBLIC, "--anchors", made / "anchors")
    assert (code, "is not in the journal" in said) == (1, True)


def test_a_clock_that_was_set_back_while_it_ran_is_told_though_nothing_was_changed(made, tmp_path):
    one = Opened(made / "bundle.zip")
    the_clock_turned_back(one)
    one.made_good(OURS)
    said = verified(made, one.packed(tmp_path / "bundle.zip"), "--key", PUBLIC)[1]
    assert "the clock was set back" in said


def test_without_a_key_nobody_says_that_it_is_whole(made, tmp_path):
    code, said = verified(made, "bundle.zip")
    assert (code, PUBLIC in said) == (2, True)
    one = Opened(made / "bundle.zip")
    the_signature_removed(one)
    code, said = verified(made, one.packed(tmp_path / "bundle.zip"))
    assert (code, "anybody may have made it" in said) == (2, True)


@pytest.mark.parametrize("content", [b"", b"PK", b"PK\x03\x04" + b"\xff" * 200, None])
def test_what_is_no_bundle_is_told_in_one_sentence(made, tmp_path, content):
    path = tmp_path / "bundle.zip"
    if content is not None:
        path.write_bytes(content)
    code, said = verified(made, path, "--key", PUBLIC)
    assert code == 1
    assert "cannot be read" in said


@pytest.mark.parametrize("words", [("--key", "x"), ("--key", PUBLIC, "--anchors", "none")])
def test_a_key_or_anchors_that_cannot_be_read_are_told(made, words):
    code, said = verified(made, "bundle.zip", *words)
    assert (code, "cannot be read" in said) == (1, True)


def test_a_byte_anywhere_in_the_bundle_is_found(made, tmp_path):
    content = (made / "bundle.zip").read_bytes()
    path = tmp_path / "bundle.zip"
    for number in range(60):
        bent = bytearray(content)
        bent[number * 7919 % len(content)] ^= 0x10
        path.write_bytes(bytes(bent))
        problems, _, _ = verify.problems_of(path, bytes.fromhex(PUBLIC), None)
        assert problems, number

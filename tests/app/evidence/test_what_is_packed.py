"""What a bundle's zip file may say of its files: nothing hides in it, and nothing is obeyed."""

import tracemalloc
import zipfile

from tampering import PUBLIC, Opened, verified

from workbench.app.evidence import verify


def test_a_field_in_front_of_a_file_alone_is_found(made, tmp_path):
    path = tmp_path / "bundle.zip"
    with zipfile.ZipFile(made / "bundle.zip") as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            info = zipfile.ZipInfo(name)
            info.extra = b"\xfe\xca\x04\x00hide" * (name == "report.html")
            new.writestr(info, old.read(name))
            info.extra = b""
    with zipfile.ZipFile(path) as one:
        assert not any(info.extra for info in one.infolist())
    code, said = verified(made, path, "--key", PUBLIC)
    assert (code, "fields in front of it" in said) == (1, True)


def test_what_a_terminal_obeys_is_printed_as_text(made, tmp_path):
    one = Opened(made / "bundle.zip")
    one.files["x\x1b[2J\nwhole, as it was signed"] = b""
    said = verified(made, one.packed(tmp_path / "bundle.zip"), "--key", PUBLIC)[1]
    assert "x\\x1b[2J\\nwhole" in said
    assert "\x1b" not in said


def test_a_signature_that_is_larger_than_memory_is_not_unpacked(made, tmp_path):
    one = Opened(made / "bundle.zip")
    one.files[verify.SIGNATURE] += b" " * 2**24
    path = one.packed(tmp_path / "bundle.zip")
    tracemalloc.start()
    verify.problems_of(path, None, None)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 2**24

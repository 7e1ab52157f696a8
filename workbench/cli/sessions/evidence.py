"""`workbench evidence`: a session as one signed file, its key, and the script that verifies it."""

import time
from contextlib import closing
from hashlib import sha256
from pathlib import Path

from workbench.app.evidence.bundle import verify_script, write_bundle
from workbench.app.evidence.packing import signed_message
from workbench.app.evidence.signing import make_key, read_key, time_stamp_request
from workbench.app.records.session_archive import open_journal
from workbench.cli.arguments.upkeep import Evidence
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import progress
from workbench.formats.files.whole_files import write_whole
from workbench.model.errors import InputError

KEY, SCRIPT = "key", "script"
"""What is typed in a session's place to have a key made, or verify.py written."""


def evidence(typed: Evidence) -> int:
    """Write the bundle, or a key."""
    if typed.session == KEY:
        return _key(typed)
    if typed.session == SCRIPT:
        return _script(typed)
    out = typed.out or Path("evidence.zip")
    key = None if typed.sign is None else read_key(typed.sign)
    with closing(open_journal(Path(typed.session))) as journal:
        if out.resolve().is_relative_to(journal.folder.resolve()):
            raise InputError(f"{out}: lies in the session; evidence of it goes elsewhere")
        with progress("evidence") as report:
            report(0.0, "the session is verified, computed again and packed")
            made = write_bundle(journal, out, time.time(), key)
    print(f"{out}: {made.entries} entries, head {made.head}")
    if key is None:
        print("not signed; `workbench evidence key` makes a key for --sign")
    else:
        print(f"signed; public key {key.public_key().public_bytes_raw().hex()}")
    if not made.has_pdf:
        print("without report.pdf, which needs pip install 'workbench[evidence]'")
    if typed.stamp:
        asked = out.with_suffix(".tsq")
        write_whole(asked, time_stamp_request(signed_message(made.manifest)))
        # What the request names, to be told to whoever verifies the stamp.
        write_whole(out.with_suffix(".stamped"), signed_message(made.manifest))
        print(f"{asked}: the request for a time stamp of {out.with_suffix('.stamped')}")
    return SUCCESS


def _key(typed: Evidence) -> int:
    if typed.sign is not None or typed.stamp:
        raise InputError("a new key signs nothing yet: leave --sign and --stamp out")
    path = typed.out or Path("evidence.key")
    print(f"{path}: keep it where no one else can read it")
    print(f"public key, for those who verify: {make_key(path)}")
    return SUCCESS


def _script(typed: Evidence) -> int:
    if typed.sign is not None or typed.stamp:
        raise InputError("verify.py is not signed: leave --sign and --stamp out")
    path = typed.out or Path("verify.py")
    if path.exists():
        raise InputError(f"{path}: is there already; nothing is overwritten")
    content = verify_script()
    write_whole(path, content)
    print(f"{path}: verifies bundles; SHA-256 {sha256(content).hexdigest()}")
    return SUCCESS

"""Modules and folders of RAPID, written and checked."""

from workbench.formats.rapid.check import check
from workbench.formats.rapid.problems import LEFT_OUT, UNKNOWN_NAME, UNREADABLE, WRONG


def module(body, rest="", name="m"):
    """A module with a main; its body begins in line 4."""
    return f"MODULE {name}\n{rest}\nPROC main()\n{body}\nENDPROC\nENDMODULE\n"


def written(folder, files):
    """Write texts or bytes by their paths, and give the folder."""
    for path, content in files.items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return folder


def checked(folder, files, signals=()):
    """Everything that is found in files that lie in a folder, and that folder is given."""
    return check([written(folder, files)], signals)


def program(folder, body, rest="", signals=()):
    """Everything that is found in one program."""
    return check([written(folder, {"m.mod": module(body, rest)}) / "m.mod"], signals)


def wrong(found):
    """What is wrong, as line and words."""
    return [(one.line, one.what) for one in found.of(WRONG)]


def unreadable(found):
    """What cannot be read, as messages tell it."""
    return [str(one) for one in found.of(UNREADABLE)]


def unknown(found):
    """Names that are not known: what they are used as, and how often."""
    return {one.name: (one.use, one.uses) for one in found.names(UNKNOWN_NAME)}


def left_out(found):
    """Names that are not executed, and how often they are used."""
    return {one.name: one.uses for one in found.names(LEFT_OUT)}

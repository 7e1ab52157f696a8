"""Xacro files expanded to plain URDF.

Source: https://github.com/ros/xacro
"""

from pathlib import Path
from typing import Any

import xacro

from workbench.formats.files.toml_keys import shown
from workbench.formats.files.whole_files import read_whole
from workbench.formats.files.xml_elements import LARGEST_FILE
from workbench.model.errors import FileError

NAMESPACE = b"http://www.ros.org/wiki/xacro"


def is_xacro(path: Path) -> bool:
    """Whether a file has to be expanded before it is a URDF.

    Raises:
        FileError: it cannot be read.
    """
    content = read_whole(path, LARGEST_FILE)
    return NAMESPACE in content and b"xacro:" in content.replace(NAMESPACE, b"")


def expanded(path: Path, arguments: dict[str, str]) -> bytes:
    """The URDF that a xacro file stands for.

    Args:
        path: of the file; what it includes is looked up beside it.
        arguments: for its `xacro:arg` elements.

    Raises:
        FileError: xacro cannot make sense of it.
    """
    try:
        document: Any = xacro.process_file(str(path), mappings=dict(arguments))
    except Exception as error:  # it evaluates expressions, which raise whatever they like
        said = shown(" ".join(str(error).split())) if str(error) else type(error).__name__
        raise FileError(path, f"cannot be expanded by xacro: {said}") from None
    return document.toxml(encoding="utf-8")

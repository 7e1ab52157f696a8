#!/bin/sh
# Installs the workbench from the files beside this one, without a network.
# Usage: install.sh [FOLDER]      FOLDER becomes a virtual environment; `workbench` otherwise
set -eu
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
folder=${1:-workbench}

if [ -e "$folder" ]; then
    echo "$folder is there already; name another folder, or move it away." >&2
    exit 2
fi
if ! (cd "$here" && sha256sum --check --quiet --strict SHA256SUMS); then
    echo "What was unpacked is not what was packed; nothing was installed." >&2
    exit 2
fi
# Whatever lies among the wheels may be installed: a file too many is as bad as one that was changed.
among=$(cd "$here" && find wheels ! -type d | LC_ALL=C sort)
packed=$(sed -n 's|^[0-9a-f]*  \(wheels/\)|\1|p' "$here/SHA256SUMS" | LC_ALL=C sort)
if [ "$among" != "$packed" ]; then
    echo "There are wheels that were not packed; nothing was installed." >&2
    exit 2
fi
for python in ${PYTHON:-python3.12 python3.11 python3.13 python3}; do
    "$python" -c 'import sys, ensurepip, venv; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' \
        2>/dev/null || continue
    # Half an environment is none: a second try would find it in the way.
    trap 'rm -rf -- "$folder"' EXIT
    trap 'exit 130' HUP INT TERM
    "$python" -m venv "$folder"
    "$folder/bin/python" -m pip --disable-pip-version-check --isolated install --quiet --no-index \
        --find-links "$here/wheels" --constraint "$here/constraints.txt" \
        --requirement "$here/requirements.txt"
    trap - EXIT HUP INT TERM
    echo "Installed in $folder by $("$python" --version). Next:"
    echo "    $folder/bin/workbench compile    # once, about a minute; otherwise before the first task"
    echo "    $folder/bin/workbench doctor     # what is there, and what is missing"
    exit 0
done
echo "Python 3.11, 3.12 or 3.13 with its venv is needed, and none was found." >&2
echo "On Debian or Ubuntu: apt-get install python3-venv; under another name: PYTHON=/path $0" >&2
exit 2

#!/usr/bin/env bash
# Makes a virtual environment with Python 3.11, 3.12 or 3.13.   Usage: setup/venv.sh FOLDER
set -euo pipefail

for python in ${PYTHON:-python3.12 python3.11 python3.13 python3}; do
    if "$python" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' \
        2>/dev/null; then
        if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
            # Debian keeps these two apart from Python itself.
            version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
            bash "$(dirname "$0")/debian.sh" "python$version-venv"
        fi
        echo "Making $1 with $("$python" --version)"
        rm -rf "$1"
        "$python" -m venv "$1"
        exit 0
    fi
done

echo "Python 3.11, 3.12 or 3.13 is needed, and none was found." >&2
echo "On Debian or Ubuntu: sudo apt-get install -y python3 python3-venv" >&2
echo "If it has another name or place: make PYTHON=/path/to/python3.12" >&2
exit 1

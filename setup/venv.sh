#!/usr/bin/env bash
# Makes a virtual environment with Python 3.11, 3.12 or 3.13, and asks for the Debian packages that
# are missing, all at once.   Usage: setup/venv.sh FOLDER PACKAGE...
set -euo pipefail
folder=$1
shift

# The pip that comes with Python 3.11 takes six times as long to find out what fits together.
install_pip() {
    local log="$folder/pip.log"
    local pip=("$folder/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile)
    if ! "${pip[@]}" --constraint constraints.txt hatchling 2>"$log"; then
        echo "pip cannot install hatchling, the first package; $log has what it printed." >&2
        echo "Behind a proxy set HTTPS_PROXY, for its certificate PIP_CERT, for a mirror PIP_INDEX_URL." >&2
        echo "Without a network: docs/service.md." >&2
        return 1
    fi
    "${pip[@]}" "pip>=25.1" 2>>"$log" || true
}

for python in ${PYTHON:-python3.12 python3.11 python3.13 python3}; do
    if "$python" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' \
        2>/dev/null; then
        if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
            # Debian keeps these two apart from Python itself.
            version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
            set -- "python$version-venv" "$@"
        fi
        bash "$(dirname "$0")/debian.sh" "$@"
        echo "Making $folder with $("$python" --version)"
        rm -rf "$folder"
        "$python" -m venv "$folder"
        install_pip
        exit 0
    fi
done

echo "Python 3.11, 3.12 or 3.13 is needed, and none was found." >&2
echo "On Debian or Ubuntu: sudo apt-get install -y python3 python3-venv" >&2
echo "If it has another name or place: make PYTHON=/path/to/python3.12" >&2
exit 1

#!/usr/bin/env bash
# Debian packages that pip cannot bring: installs those that are missing when it may, otherwise
# says what to type.   Usage: setup/debian.sh PACKAGE...
set -euo pipefail

# Whether what a package brings is there, wherever it came from.
is_there() {
    case "$1" in
        libusb-1.0-0) has_library libusb-1.0.so.0 ;;
        libgl1) has_library libGL.so.1 ;;
        libegl1) has_library libEGL.so.1 ;;
        libx11-6) has_library libX11.so.6 ;;
        libidn2-0) has_library libidn2.so.0 ;;
        libgomp1) has_library libgomp.so.1 ;;
        # Without windows, tabs and menus that nobody sees; the one with them does it as well.
        chromium-headless-shell) command -v chromium-headless-shell chromium >/dev/null ;;
        unzip) command -v unzip >/dev/null ;;
        libarchive-tools) command -v bsdtar >/dev/null ;;
        p7zip-full) command -v 7z >/dev/null ;;
        fonts-dejavu-core) [ -e /usr/share/fonts/truetype/dejavu/DejaVuSans.ttf ] ;;
        *) dpkg-query --show --showformat='${Status}' "$1" 2>/dev/null | grep -q 'ok installed' ;;
    esac
}

has_library() {
    PATH="$PATH:/usr/sbin:/sbin" ldconfig -p | grep -F "$1 " >/dev/null
}

missing=()
for package in "$@"; do
    is_there "$package" || missing+=("$package")
done
[ "${#missing[@]}" -eq 0 ] && exit 0

if ! command -v apt-get >/dev/null; then
    echo "Missing on this system, by their Debian names: ${missing[*]}" >&2
    echo "Install what corresponds to them here, then run make again." >&2
    exit 1
fi

if [ "$(id -u)" -eq 0 ]; then
    as_root=(env)
elif sudo -n true 2>/dev/null; then
    as_root=(sudo -n env)
else
    echo "Debian packages are missing: ${missing[*]}" >&2
    echo "Type this, then run make again:" >&2
    echo "    sudo apt-get update && sudo apt-get install -y ${missing[*]}" >&2
    exit 1
fi

echo "Installing Debian packages: ${missing[*]}"
# Another installation, or the system's own updates, may be under way: wait for it.
wait_for_it=(-o DPkg::Lock::Timeout=600)
"${as_root[@]}" apt-get -qq "${wait_for_it[@]}" update
"${as_root[@]}" DEBIAN_FRONTEND=noninteractive \
    apt-get -qq "${wait_for_it[@]}" install -y --no-install-recommends "${missing[@]}" >/dev/null

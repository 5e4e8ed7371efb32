#!/bin/sh
# Makes the virtual environment with everything that shapemorph and its tests need, and
# installs the system libraries of VTK and Open3D where that is possible.
#
#   PYTHON   interpreter to build on, default python3 (3.11 to 3.13)
#   VENV     folder of the environment, default .venv
#
# `make setup` calls it; running it again mends what is missing and repeats nothing else.
set -eu
cd "$(dirname "$0")/.."

PYTHON=${PYTHON:-python3}
VENV=${VENV:-.venv}

say() { printf 'setup: %s\n' "$*" >&2; }
stop() { say "$*"; exit 1; }

check_python() {
    command -v "$PYTHON" >/dev/null 2>&1 ||
        stop "expected Python 3.11 to 3.13, found no '$PYTHON': install it or say make setup PYTHON=/path/to/python3.11"
    version=$("$PYTHON" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    case "$version" in
        3.11 | 3.12 | 3.13) ;;
        *) stop "expected Python 3.11 to 3.13, '$PYTHON' is $version: say make setup PYTHON=/path/to/python3.11" ;;
    esac
}

make_venv() {
    [ -x "$VENV/bin/python" ] && "$VENV/bin/python" -c 'import pip' 2>/dev/null && return
    "$PYTHON" -c 'import ensurepip, venv' 2>/dev/null ||
        stop "'$PYTHON' cannot make virtual environments: on Debian, apt-get install python3-venv"
    say "making $VENV with Python $version"
    "$PYTHON" -m venv --clear "$VENV"
}

# Runs a command that says nothing when all is well and its last lines when it fails.
quietly() {
    log=$(mktemp)
    if "$@" >"$log" 2>&1; then rm -f "$log"; return 0; fi
    tail -n 15 "$log" >&2
    rm -f "$log"
    return 1
}

install_packages() {
    if [ -e "$VENV/.installed" ]; then say "bringing the Python packages up to date"
    else say "installing Python packages: 2 GB, some minutes"; fi
    quietly "$VENV/bin/python" -m pip install --disable-pip-version-check -e '.[dev]' ||
        stop "pip could not install the packages: mend what it says above and run this again"
}

# Prints the Debian package of every shared library that the loader does not find.
missing_packages() {
    [ "$(uname -s)" = Linux ] || return 0
    "$VENV/bin/python" - <<'END'
import ctypes

PACKAGES = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libX11.so.6": "libx11-6",
    "libusb-1.0.so.0": "libusb-1.0-0",
}
missing = []
for library, package in PACKAGES.items():
    try:
        ctypes.CDLL(library)
    except OSError:
        missing.append(package)
print(*missing)
END
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo -n "$@"; fi
}

can_install() {
    command -v apt-get >/dev/null 2>&1 || return 1
    [ "$(id -u)" -eq 0 ] || { command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; }
}

# A refused refresh of the list is no reason to stop: the packages may be known already.
apt_install() {
    quietly as_root apt-get update || say "apt-get update failed, trying without"
    # shellcheck disable=SC2086  # one word per package is meant
    quietly as_root env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y --no-install-recommends $1
}

install_libraries() {
    missing=$(missing_packages)
    [ -n "$missing" ] || return 0
    if can_install; then
        say "installing system libraries: $missing"
        apt_install "$missing" || say "apt-get could not install them"
        missing=$(missing_packages)
    fi
    [ -z "$missing" ] && return 0
    say "pictures and ICP need system libraries that are missing here. Install them with"
    say "    sudo apt-get install --no-install-recommends $missing"
    say "(names of Debian and Ubuntu); everything else works without them"
}

check_python
make_venv
install_packages
install_libraries
say "ready: $VENV/bin/shapemorph"

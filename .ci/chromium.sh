#!/bin/sh
# Prints the path of a Chromium for the browser test; installs one from the system's packages when there is none.
# Order: $BREASTRIG_CHROMIUM, a browser on the PATH, the system's packages.  Only the path goes to standard output.
# Beside Debian's Chromium its headless shell is installed, which draws the pages of most tests with less work.
set -eu

find_browser() {
    for name in chromium chromium-browser google-chrome google-chrome-stable; do
        if command -v "$name" 2>/dev/null; then return 0; fi
    done
    return 1
}

refuse() {
    echo "error: $1" >&2
    exit 1
}

if [ -n "${BREASTRIG_CHROMIUM:-}" ]; then
    [ -x "$BREASTRIG_CHROMIUM" ] || refuse "BREASTRIG_CHROMIUM is $BREASTRIG_CHROMIUM, which is not a program."
    echo "$BREASTRIG_CHROMIUM"
    exit 0
fi
find_browser && exit 0

command -v apt-get >/dev/null 2>&1 ||
    refuse "The browser test needs Chromium: install it with your system's packages, or set BREASTRIG_CHROMIUM to its path."
as_root=""
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 ||
        refuse "The browser test needs Chromium: ask an administrator for 'apt-get install chromium', or set BREASTRIG_CHROMIUM."
    as_root="sudo"
fi
echo "No Chromium found: installing it from the system's packages." >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
{
    $as_root apt-get update &&
        $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends chromium fonts-dejavu-core &&
        {
            $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends chromium-headless-shell ||
                true # the tests do without
        }
} </dev/null >"$log" 2>&1 || {
    tail -n 20 "$log" >&2
    refuse "Chromium could not be installed from the system's packages; install it, or set BREASTRIG_CHROMIUM to its path."
}
find_browser || refuse "The system's package chromium was installed, but no browser is on the PATH."

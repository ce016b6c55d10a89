#!/bin/sh
# Prints the path of a Chromium for the browser test; installs one from the system's packages when there is none.
# Order: $BREASTRIG_CHROMIUM, a browser on the PATH, the system's packages.  Only the path goes to standard output.
# Beside Debian's Chromium its headless shell is installed, which draws the pages of most tests with less work.
set -eu
. "$(dirname "$0")/system_package.sh"

find_browser() {
    for name in chromium chromium-browser google-chrome google-chrome-stable; do
        if command -v "$name" 2>/dev/null; then return 0; fi
    done
    return 1
}

if [ -n "${BREASTRIG_CHROMIUM:-}" ]; then
    [ -x "$BREASTRIG_CHROMIUM" ] || refuse "BREASTRIG_CHROMIUM is $BREASTRIG_CHROMIUM, which is not a program."
    echo "$BREASTRIG_CHROMIUM"
    exit 0
fi
find_browser && exit 0
system_package Chromium BREASTRIG_CHROMIUM chromium fonts-dejavu-core
(system_package "Chromium's headless shell" BREASTRIG_CHROMIUM chromium-headless-shell) || true # the tests do without
find_browser || refuse "The system's package chromium was installed, but no browser is on the PATH."

#!/bin/sh
# Prints the path of nginx for the tests; installs Debian's package when there is none.
# Order: $BREASTRIG_NGINX, the PATH, the system's usual place, the system's packages.  Only the path goes to standard output.
set -eu

find_nginx() {
    if command -v nginx 2>/dev/null; then return 0; fi
    [ -x /usr/sbin/nginx ] && echo /usr/sbin/nginx # not on everybody's PATH
}

refuse() {
    echo "error: $1" >&2
    exit 1
}

if [ -n "${BREASTRIG_NGINX:-}" ]; then
    [ -x "$BREASTRIG_NGINX" ] || refuse "BREASTRIG_NGINX is $BREASTRIG_NGINX, which is not a program."
    echo "$BREASTRIG_NGINX"
    exit 0
fi
find_nginx && exit 0

command -v apt-get >/dev/null 2>&1 ||
    refuse "The tests need nginx: install it with your system's packages, or set BREASTRIG_NGINX to its path."
as_root=""
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 ||
        refuse "The tests need nginx: ask an administrator for 'apt-get install nginx-light', or set BREASTRIG_NGINX."
    as_root="sudo"
fi
echo "No nginx found: installing it from the system's packages." >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
{
    $as_root apt-get update &&
        # the tests start one of their own: none is to run besides
        $as_root env DEBIAN_FRONTEND=noninteractive RUNLEVEL=1 apt-get install -y --no-install-recommends nginx-light
} </dev/null >"$log" 2>&1 || {
    tail -n 20 "$log" >&2
    refuse "nginx could not be installed from the system's packages; install it, or set BREASTRIG_NGINX to its path."
}
find_nginx || refuse "The system's package nginx-light was installed, but no nginx is in its usual places."

#!/bin/sh
# Prints the path of nginx for the tests; installs Debian's package when there is none.
# Order: $BREASTRIG_NGINX, the PATH, the system's usual place, the system's packages.  Only the path goes to standard output.
set -eu
. "$(dirname "$0")/system_package.sh"

find_nginx() {
    if command -v nginx 2>/dev/null; then return 0; fi
    [ -x /usr/sbin/nginx ] && echo /usr/sbin/nginx # not on everybody's PATH
}

if [ -n "${BREASTRIG_NGINX:-}" ]; then
    [ -x "$BREASTRIG_NGINX" ] || refuse "BREASTRIG_NGINX is $BREASTRIG_NGINX, which is not a program."
    echo "$BREASTRIG_NGINX"
    exit 0
fi
find_nginx && exit 0
system_package nginx BREASTRIG_NGINX nginx-light
find_nginx || refuse "The system's package nginx-light was installed, but no nginx is in its usual places."

#!/bin/sh
# Prints the folder of PostgreSQL's server programs for the tests; installs Debian's package when there are none.
# Order: $BREASTRIG_POSTGRES, the newest in the system's usual places, the PATH, the system's packages.
# Only the folder goes to standard output.
set -eu

find_programs() {
    newest=$(ls -d /usr/lib/postgresql/*/bin/initdb /usr/pgsql-*/bin/initdb 2>/dev/null | sort -V | tail -n 1)
    [ -n "$newest" ] || newest=$(command -v initdb 2>/dev/null) || return 1
    dirname "$(readlink -f "$newest")"
}

refuse() {
    echo "error: $1" >&2
    exit 1
}

if [ -n "${BREASTRIG_POSTGRES:-}" ]; then
    [ -x "$BREASTRIG_POSTGRES/initdb" ] || refuse "BREASTRIG_POSTGRES is $BREASTRIG_POSTGRES, where there is no initdb."
    echo "$BREASTRIG_POSTGRES"
    exit 0
fi
find_programs && exit 0

command -v apt-get >/dev/null 2>&1 ||
    refuse "The tests need PostgreSQL's server: install it with your system's packages, or set BREASTRIG_POSTGRES to the folder of its programs."
as_root=""
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 ||
        refuse "The tests need PostgreSQL's server: ask an administrator for 'apt-get install postgresql', or set BREASTRIG_POSTGRES."
    as_root="sudo"
fi
echo "No PostgreSQL found: installing it from the system's packages." >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
{
    $as_root apt-get update &&
        # the tests start a server of their own: none is to run besides
        $as_root env DEBIAN_FRONTEND=noninteractive RUNLEVEL=1 apt-get install -y --no-install-recommends postgresql
} </dev/null >"$log" 2>&1 || {
    tail -n 20 "$log" >&2
    refuse "PostgreSQL could not be installed from the system's packages; install it, or set BREASTRIG_POSTGRES to the folder of its programs."
}
find_programs || refuse "The system's package postgresql was installed, but no initdb is in its usual places."

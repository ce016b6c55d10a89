#!/bin/sh
# Prints the folder of PostgreSQL's server programs for the tests; installs Debian's package when there are none.
# Order: $BREASTRIG_POSTGRES, the newest in the system's usual places, the PATH, the system's packages.
# Only the folder goes to standard output.
set -eu
. "$(dirname "$0")/system_package.sh"

find_programs() {
    newest=$(ls -d /usr/lib/postgresql/*/bin/initdb /usr/pgsql-*/bin/initdb 2>/dev/null | sort -V | tail -n 1)
    [ -n "$newest" ] || newest=$(command -v initdb 2>/dev/null) || return 1
    dirname "$(readlink -f "$newest")"
}

if [ -n "${BREASTRIG_POSTGRES:-}" ]; then
    [ -x "$BREASTRIG_POSTGRES/initdb" ] || refuse "BREASTRIG_POSTGRES is $BREASTRIG_POSTGRES, where there is no initdb."
    echo "$BREASTRIG_POSTGRES"
    exit 0
fi
find_programs && exit 0
system_package "PostgreSQL's server" BREASTRIG_POSTGRES postgresql
find_programs || refuse "The system's package postgresql was installed, but no initdb is in its usual places."

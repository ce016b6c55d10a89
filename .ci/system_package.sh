# Sourced by the scripts beside it: what a test needs that is no Python or Node package.  Plain sh.

refuse() {
    echo "error: $1" >&2
    exit 1
}

# system_package PROGRAM VARIABLE NAME [NAME...]: installs Debian's packages of these names, or says what to do instead.
# The tests start what they need themselves: no service of a package is to run besides.
system_package() {
    program=$1 variable=$2
    shift 2
    command -v apt-get >/dev/null 2>&1 ||
        refuse "The tests need $program: install it with your system's packages, or set $variable to where it is."
    as_root=""
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null 2>&1 ||
            refuse "The tests need $program: ask an administrator for 'apt-get install $*', or set $variable to where it is."
        as_root="sudo"
    fi
    echo "No $program found: installing it from the system's packages." >&2
    log=$(mktemp)
    trap 'rm -f "$log"' EXIT
    {
        $as_root apt-get update &&
            $as_root env DEBIAN_FRONTEND=noninteractive RUNLEVEL=1 apt-get install -y --no-install-recommends "$@"
    } </dev/null >"$log" 2>&1 || {
        tail -n 20 "$log" >&2
        refuse "$program could not be installed from the system's packages; install it, or set $variable to where it is."
    }
}

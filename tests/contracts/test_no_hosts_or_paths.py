"""Committed files name no registry host and no folder of somebody's machine.

Both work for their author only: a lock file that remembers one registry breaks behind another, and a path
under a home folder exists nowhere else.  The patterns are put together from pieces, lest this file match itself.
"""

import re

REGISTRY_HOSTS = re.compile(
    "|".join(
        re.escape(".".join(parts))
        for parts in (
            ("registry", "npmjs", "org"),
            ("files", "pythonhosted", "org"),
            ("pypi", "org/simple"),
            ("deb", "debian", "org"),
            ("registry", "yarnpkg", "com"),
        )
    )
    + r"|--index"
    + r"-url|--reg"
    + r"istry\b"
)
RESOLVED = re.compile(r'"resolved"\s*:\s*"http')
MACHINE_PATHS = re.compile(r"(?<![\w.*/-])/(?:ro" + r"ot/|ho" + r"me/[a-z]|Us" + r"ers/[a-z]|wo" + r"rk/[a-z])")


def lines_with(pattern: re.Pattern[str], texts: dict[str, str]) -> list[str]:
    return [
        f"{name}:{number}: {line.strip()[:120]}"
        for name, text in texts.items()
        for number, line in enumerate(text.splitlines(), start=1)
        if pattern.search(line)
    ]


def test_no_file_names_a_registry_host(project_texts: dict[str, str]) -> None:
    assert not lines_with(REGISTRY_HOSTS, project_texts), "leave the host out: it is set where the program is installed"


def test_lock_files_do_not_remember_where_packages_came_from(project_texts: dict[str, str]) -> None:
    assert not lines_with(RESOLVED, {name: text for name, text in project_texts.items() if name.endswith(".json")}), (
        "call npm install in web/, whose .npmrc leaves addresses out of the lock file"
    )


def test_no_file_holds_a_path_of_one_machine(project_texts: dict[str, str]) -> None:
    assert not lines_with(MACHINE_PATHS, project_texts), "write the path from the top of the checkout"


def test_the_patterns_catch_what_they_are_for() -> None:
    home, host = "/ho" + "me/somebody/scans", "https://registry." + "npmjs.org/three"
    assert lines_with(MACHINE_PATHS, {"a": f'open("{home}")'})
    assert lines_with(REGISTRY_HOSTS, {"a": host})
    assert lines_with(RESOLVED, {"package-lock.json": f'"resolved": "{host}"'})

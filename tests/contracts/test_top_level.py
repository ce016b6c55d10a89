"""The top level stays small: a newcomer sees the whole house at one glance."""

ALLOWED = {"pyproject.toml", "server", "web", "model_assets", "tests", "README.md", "Makefile", "LICENSE"}


def test_the_top_level_holds_only_what_the_contract_allows(project_files: list[str]) -> None:
    names = {name.split("/")[0] for name in project_files}
    surplus = {name for name in names if not name.startswith(".")} - ALLOWED
    assert not surplus, f"these belong into one of the folders: {sorted(surplus)}"


def test_the_top_level_holds_what_a_newcomer_needs(project_files: list[str]) -> None:
    assert {"README.md", "LICENSE", "Makefile", "pyproject.toml", ".ci/run"} <= set(project_files)

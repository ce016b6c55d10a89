"""The top level holds what the user asked for, and what tools and contributors look for there; nothing else."""

ASKED_FOR = {"pyproject.toml", "server", "web", "model_assets", "tests", "README.md"}
FOR_NEWCOMERS = {"LICENSE", "Makefile", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "CITATION.cff", "docs"}


def test_the_top_level_holds_only_what_the_contract_allows(project_files: list[str]) -> None:
    names = {name.split("/")[0] for name in project_files}
    surplus = {name for name in names if not name.startswith(".")} - ASKED_FOR - FOR_NEWCOMERS
    assert not surplus, f"these belong into one of the folders: {sorted(surplus)}"


def test_the_top_level_holds_what_a_newcomer_needs(project_files: list[str]) -> None:
    assert {name.split("/")[0] for name in project_files} >= ASKED_FOR | FOR_NEWCOMERS
    assert {".ci/run", ".github/workflows/ci.yml", ".pre-commit-config.yaml"} <= set(project_files)

"""The top level holds what the user asked for, and what tools and contributors look for there; nothing else."""

ASKED_FOR = {"pyproject.toml", "server", "web", "model_assets", "tests", "README.md"}
EXPECTED_THERE = {"LICENSE", "Makefile", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "CITATION.cff", "docs"} | {
    "mkdocs.yml",
    "CODE_OF_CONDUCT.md",
}


def test_the_top_level_holds_only_what_the_contract_allows(project_files: list[str]) -> None:
    names = {name.split("/")[0] for name in project_files}
    surplus = {name for name in names if not name.startswith(".")} - ASKED_FOR - EXPECTED_THERE
    assert not surplus, f"these belong into one of the folders: {sorted(surplus)}"


def test_the_top_level_holds_what_a_newcomer_needs(project_files: list[str]) -> None:
    assert {name.split("/")[0] for name in project_files} >= ASKED_FOR
    assert {"LICENSE", "Makefile", ".ci/run"} <= set(project_files)

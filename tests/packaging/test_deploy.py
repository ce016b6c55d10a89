"""What deploys BreastRig: each file as its own linter reads it, and what is to be true of all of them."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from breastrig.scan.limits import IMAGE_ZIP_BYTES, MEBIBYTE

DEPLOY = Path("server/packaging/deploy")
EXPOSURE = 20  # tenths, of 100: what systemd-analyze calls OK begins at 50


def run(*command: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment or None)


def program(name: str) -> str:
    """Of this environment, else of the system; the test is skipped where there is none."""
    found = shutil.which(name, path=str(Path(sys.executable).parent)) or shutil.which(name)
    if found is None:
        pytest.skip(f"{name} is not installed here")
    return found


def test_hadolint_has_nothing_to_say_of_the_dockerfile(repository: Path) -> None:
    found = run(program("hadolint"), repository / DEPLOY / "Dockerfile")
    assert (found.returncode, found.stdout + found.stderr) == (0, "")
    text = (repository / DEPLOY / "Dockerfile").read_text()
    assert text.count("\nFROM ") + text.startswith("FROM ") >= 2
    assert text.rindex("\nUSER 10001:10001") > text.rindex("\nFROM ")
    assert "\nHEALTHCHECK " in text


def test_compose_is_of_its_schema_and_each_service_has_a_read_only_root(repository: Path) -> None:
    file = repository / DEPLOY / "compose.yaml"
    found = run(program("check-jsonschema"), "--builtin-schema", "vendor.compose-spec", file)
    assert found.returncode == 0, found.stdout + found.stderr
    document = yaml.safe_load(file.read_text())
    for name, service in document["services"].items():
        assert service["read_only"], name
        assert service["cap_drop"] == ["ALL"], name
        assert "no-new-privileges:true" in service["security_opt"], name
        assert "ports" not in service or name == "caddy"
    assert document["networks"]["fits"]["internal"]
    assert document["services"]["scheduler"]["networks"] == ["fits"]
    proxy = document["services"]["caddy"]["networks"]["front"]["ipv4_address"]
    assert document["services"]["service"]["environment"]["BREASTRIG_TRUSTED_PROXY"] == proxy
    dockerfile = (file.parent / document["services"]["service"]["build"]["context"]).resolve()
    assert dockerfile == repository.resolve()


def test_the_settings_in_all_files_are_settings(repository: Path) -> None:
    from breastrig.api.settings import SETTINGS

    named = {
        name
        for file in ("Dockerfile", "compose.yaml", "breastrig.service")
        for name in re.findall(r"BREASTRIG_([A-Z_]+)[:=]", (repository / DEPLOY / file).read_text())
    }
    assert {"TOKEN_FILE", "TRUSTED_PROXY", "DATA"} <= named
    assert {name.lower() for name in named} - {"site", "tls", "upstream"} <= set(SETTINGS)


def test_caddy_reads_its_file(repository: Path, tmp_path: Path) -> None:
    file, home = repository / DEPLOY / "Caddyfile", {"HOME": str(tmp_path), "BREASTRIG_SITE": "scans.hospital.example"}
    found = run(program("caddy"), "validate", "--config", file, "--adapter", "caddyfile", **home)
    assert found.returncode == 0, found.stderr
    assert run(program("caddy"), "fmt", file, **home).stdout == file.read_text()


def test_caddy_takes_what_we_take(repository: Path) -> None:
    found = re.search(r"max_size (\d+)MB", (repository / DEPLOY / "Caddyfile").read_text())
    assert found
    assert int(found[1]) * 1_000_000 > IMAGE_ZIP_BYTES + MEBIBYTE


def test_whoever_installs_has_what_a_clinic_is_promised(repository: Path) -> None:
    promised = {"server", "users", "mri", "volume", "pacs", "backup"}  # sign-in, archive, backup: the how-to pages
    for file in (DEPLOY / "Dockerfile", DEPLOY / "breastrig.service", Path("server/packaging/wheelhouse.py")):
        extras = re.search(r"[\[\"](server,[a-z,]+)[\]\"]", (repository / file).read_text())
        assert extras, file
        assert promised <= set(extras[1].split(",")), file


def test_systemd_takes_the_unit_and_finds_it_closed(repository: Path, tmp_path: Path) -> None:
    unit = tmp_path / "breastrig.service"
    text = (repository / DEPLOY / "breastrig.service").read_text()
    unit.write_text(text.replace("/opt/breastrig/bin/breastrig", "/bin/true"))  # which is not on this machine
    analyze = program("systemd-analyze")
    found = run(analyze, "verify", "--man=no", unit)
    assert (found.returncode, found.stdout + found.stderr) == (0, "")
    found = run(analyze, "security", "--offline=true", f"--threshold={EXPOSURE}", unit)
    assert found.returncode == 0, found.stdout

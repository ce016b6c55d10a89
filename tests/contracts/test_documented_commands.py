"""Every command line that README and docs show is run as it stands, checked by what it names, or listed with a reason.

Whole fits share one: of the lines in SHARED the options are checked, and what they write is a copy of the example's.
"""

import json
import re
import shlex
import shutil
import subprocess
import threading
import tomllib
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path

import pytest
from helpers.blank_pictures import blank_pictures
from helpers.cases import new_case, new_fit, new_link, new_scan, note
from helpers.example_fits import write_example_fits
from helpers.on_disk import kept_below

from breastrig.cases.plans import put_plan
from breastrig.cli.commands import COMMANDS, GROUP
from breastrig.cli.main import main
from breastrig.index.questions import LinkSecret, put_secret, secret_of_link
from breastrig.storage.documents.fits import fits_page
from breastrig.storage.documents.patients import get_plan, listed_page
from breastrig.storage.storage import Storage

pytestmark = pytest.mark.long

KINDS = ("tutorials", "how-to", "reference", "explanation")  # folders of docs/
FENCED = re.compile(r"^```([^`\n]*)\n(.*?)^```\n", re.DOTALL | re.MULTILINE)
SPAN = re.compile(r"`([^`\n]+(?:\n[^`\n]+)?)`")
PROGRAMS = re.compile(r"(?:[A-Z_]+=\S+ )*(?:breastrig|python|pip|make|npm|pytest|\.venv/bin/\S+) \S")

SHARED = {  # the folder that each writes: which of the example's fits stands for it
    "breastrig fit standing.ply --landmarks landmarks.json -o standing/": "standing",
    "breastrig fit supine.ply -o supine/": "supine",
    "breastrig fit scan.ply --landmarks landmarks.json -o out/": "standing",
    "breastrig fit scan.ply --landmarks landmarks.json --drawing reduction:limb_mm=45 -o wise/": "standing",
    "breastrig fit scan.ply --landmarks landmarks.json --tumour L:10,45,12 -o tumour/": "standing",
}
RUN = {  # in this order, each as the lines on the right; an empty list: as it stands
    "breastrig transfer --from standing/ --to supine/ -o drawing.json": [],
    "breastrig compare --on out/ surgeon.json model.json -o superimposed/": [],
    "breastrig report standing/ --with supine/ -o report/": [],
    "breastrig export out/ -o files/": [],
    "breastrig model info | check | bind | learn": ["breastrig model info", "breastrig model check"],
    "breastrig model info": [],
    "breastrig model check": [],
    "breastrig presets list | show NAME": ["breastrig presets list", "breastrig presets show default"],
    "breastrig presets list": [],
    "breastrig presets show default": [],
    "breastrig config": [],
    "breastrig purge": ["breastrig purge --all --data data"],
}
LISTED = {  # why they are not run here, or the test that runs them
    "tests/api/access/test_provider.py": [
        "breastrig serve --users users.toml",
        "breastrig serve --users users.toml --trusted-proxy 127.0.0.1 --public-host scans.hospital.example",
    ],
    "tests/cli/test_transfer_command.py": [
        "breastrig transfer --from standing/ --to supine/ --drawing plan.json -o there.json",
    ],
    "tests/cli/test_predict_command.py": [
        "breastrig predict standing/ --stance supine -o lying/",
    ],
    "tests/cli/test_landmarks_command.py": [
        "breastrig landmarks scan.ply -o proposed.json",
    ],
    "tests/use/test_propose_marks.py": [
        "breastrig marks standing.zip supine.zip --from standing/ --to supine/ -o marks.json",
    ],
    "tests/cli/test_batch_command.py": [
        "breastrig batch manifest.csv -o results/",
    ],
    "tests/cli/test_case_command.py": [
        "breastrig case create patient/ --code K7M-4QX",
        "breastrig case add patient/ standing.ply",
        "breastrig case landmarks patient/ landmarks.json",
        "breastrig case fit patient/",
        "breastrig case predict patient/ --stance supine",
        "breastrig case plan patient/ -o plan.json",
        "breastrig case plan patient/ --put plan.json --same-patient",
        "breastrig case plan patient/ --undo 1",
        "breastrig case show patient/",
    ],
    "tests/use/test_true_size.py": [
        "breastrig case length patient/ --put suprasternal_notch nipple_L 214",
    ],
    "tests/use/test_visits.py": [
        "breastrig case visit patient/ --date 2026-03-01 --label before",
        "breastrig case visit patient/ --scan 1 --date 2026-03-01 --label before",
        'breastrig case visit patient/ --scan 2 --date 2026-09-01 --label "6 months"',
        "breastrig visits patient/ -o visits/",
    ],
    "tests/cli/test_audit_command.py": [
        "breastrig audit list DATA --of ID --since 2026-11-01",
        "breastrig audit check DATA",
        "breastrig audit check",
        "breastrig audit certificate DATA ID -o deleted.pdf",
        "breastrig audit check DATA --anchor 1273:9d3f...",
    ],
    "tests/backup/test_backup.py": [
        "breastrig backup /mnt/backups/ DATA",
        "breastrig restore /mnt/backups/breastrig-2026-11-29T101500Z.age NEW --audit DATA",
        "breastrig backup",
    ],
    "tests/report/test_protocol.py": [
        "breastrig protocol -o protocol.pdf",
    ],
    "tests/cli/test_report_command.py": [
        "breastrig report supine/ --with standing/ --plan plan.json -o report/",
    ],
    "tests/archive/test_objects.py": [
        "breastrig dicom out/ -o dicom/",
        "breastrig dicom out/ -o dicom/ --identities codes.csv",
    ],
    "tests/archive/test_slicer.py": ["breastrig export out/ -o files/ --slicer"],
    "tests/archive/test_send.py": [
        "breastrig dicom out/ --send ARCHIVE@pacs.hospital.example:11112 --identities codes.csv",
        "breastrig dicom out/ --stow https://pacs.hospital.example/dicom-web --authorization token",
    ],
    "tests/report/test_template.py": [
        "breastrig template supine/ -o template.pdf",
        "breastrig template supine/ --side L -o guide.stl",
        "breastrig template supine/ --with standing/ --plan plan.json -o template.pdf",
    ],
    "tests/volume": [
        "breastrig volume standing/ -o torso.vtu",
        "breastrig volume out/ -o torso.vtu",
        "breastrig volume out/ -o torso.msh",
    ],
    "tests/cli/test_index_command.py": [
        "breastrig case create DATA",
        "breastrig index DATA",
    ],
    "tests/cli/test_ink_command.py": [
        "breastrig ink scan.zip -o drawing.json",
    ],
    "tests/studies": [
        "breastrig evaluate cohort/ -o evidence/",
        "breastrig evaluate COHORT --quick",
        "breastrig evaluate COHORT",
        "breastrig evaluate --virtual",
        "breastrig evaluate --warped N",
        "breastrig evaluate COHORT --warped N --prone",
        "breastrig evaluate COHORT --warped 32 --prone --half validation",
        "breastrig evaluate COHORT --test docs/test_set.md",
        "breastrig evaluate MEN --model male --quick",
        "breastrig evaluate BODIES --model MODEL",
        "breastrig evaluate",
        "breastrig model learn arm/forearm.glb arm/bodies",
        "breastrig model learn MODEL BODIES",
        "python -m breastrig_studies.cohort_prior CLINIC OUT alike=FOLDER others=FOLDER",
        "python -m breastrig_studies.virtual.magnetic.image_skin images.csv 1.5 60 61 62 63",
    ],
    "tests/cli/test_lesions_of_files.py": [
        "breastrig fit mri/ --lesions lesion.dcm --landmarks nipples.json -o prone/",
    ],
    "tests/cli/test_cohort_command.py": [
        "breastrig cohort learn results/ -o prior.json",
        "breastrig cohort info prior.json",
        "breastrig fit scan.ply --prior prior.json -o out/",
        "breastrig cohort merge ours.json theirs.json -o both.json",
        "breastrig cohort remove prior.json results/P17 -o left.json",
    ],
    "tests/api/test_rigs_day.py": [
        "breastrig model check arm/forearm.glb",
        "breastrig fit arm/scan.ply --units mm --landmarks arm/landmarks.json --model arm/forearm.glb -o out",
        "breastrig report out --model arm/forearm.glb -o report",
        "breastrig serve --model arm/forearm.glb",
        "python model_assets/forearm.py arm --bodies 12",
    ],
    "tests/rig": [
        "breastrig model bind forearm.glb",
        "breastrig model check forearm.glb",
        "breastrig model bind",
        "breastrig model bind model_assets/built/male/male.glb",
    ],
    "tests/cli/test_serve_command.py": [
        "breastrig serve",
        "breastrig serve --no-token",
        "breastrig serve --data NEW",
        "breastrig serve --archives archives.toml",
    ],
    "tests/api/test_behind_proxy.py": [
        "BREASTRIG_TOKEN=... breastrig serve --trusted-proxy 127.0.0.1 --public-host scans.hospital.example",
    ],
    "tests/scale": [
        "breastrig worker tcp://SCHEDULER:8786",
        "breastrig serve --scheduler tcp://127.0.0.1:8786",
        "breastrig batch manifest.csv -o results/ --scheduler tcp://SCHEDULER:8786",
    ],
    "the name of a command in a sentence": [
        "breastrig fit",
        "breastrig fit --length A B MM",
        "breastrig report",
        "breastrig dicom",
        "breastrig dicom --send",
        "breastrig template",
        "breastrig volume",
    ],
    "tests/cli/test_main.py": [
        "breastrig COMMAND --help",
    ],
    "tests/examples": [
        "python server/examples/watch_fit.py",
    ],
    "tests/model_assets": [
        "python model_assets/correctives.py FOLDER",
        "python model_assets/build.py",
    ],
    "hours: makes men from MakeHuman's data, which is fetched": [
        "python model_assets/make_men.py MEN",
    ],
    "hours: makes 412 women": [
        "python model_assets/make_poses.py CLINIC --first 60 --women 412 --poses 1",
    ],
    "needs gmsh, which no test has": [
        "python model_assets/make_volume.py --model NAME.glb",
    ],
    "tests/contracts/test_reference_pages.py": [
        "python docs/reference/generate.py",
        "python docs/reference/pictures.py",
    ],
    "tests/contracts/test_types_fresh.py": [
        "python -m breastrig.api.write_openapi",
    ],
    "on a machine without a network, from the folder of `make wheelhouse`": [
        "python3 -m venv /opt/breastrig",
        "cd wheelhouse",
        "/opt/breastrig/bin/pip install --no-index --find-links . --require-hashes -r requirements.txt",
    ],
    "this very run": [
        "pytest tests/contracts",
    ],
}
NOT_RUN = {line: reason for reason, lines in LISTED.items() for line in lines}
BACKUP = "cp -a DATA BACKUP; rm -f BACKUP/index-*"


@pytest.fixture(scope="module")
def shown(repository: Path) -> dict[str, str]:
    """Each command line, without its remark, and the document that shows it."""
    pages = [file for kind in ("", *KINDS) for file in sorted((repository / "docs" / kind).glob("*.md"))]
    documents = [repository / "README.md", repository / "CONTRIBUTING.md", *pages]
    return {line: file.name for file in documents for line in command_lines(file.read_text())}


def command_lines(text: str) -> Iterator[str]:
    """Of code blocks without a language, and of words between sentences that begin with a program and go on."""
    for language, block in FENCED.findall(text):
        if language not in ("", "sh", "bash", "console"):
            continue
        for line in block.replace("\\\n", " ").splitlines():
            command = " ".join(re.sub(r"(^|\s+)#.*", "", line).split())
            if command:
                yield command
    for span in SPAN.findall(FENCED.sub("\n", text)):
        words = " ".join(span.split())
        if PROGRAMS.match(words):
            yield words


def is_of(line: str, *programs: str) -> bool:
    return line.split()[0] in programs


def test_every_line_is_run_checked_or_has_a_reason(shown: dict[str, str]) -> None:
    """A new one belongs into RUN, or with a reason into NOT_RUN; one that is shown no more goes."""
    known = {*SHARED, *RUN, *NOT_RUN}
    checked = {line for line in shown if is_of(line, "pip", "make", "npm") or line.startswith(".venv/bin/pip ")}
    exports = {line for line in shown if line.startswith("export PATH=")}
    new = {line: file for line, file in shown.items() if line not in known | checked | exports}
    assert not new, new
    old = known - shown.keys()
    assert not old, old


def test_reasons_are_there(repository: Path) -> None:
    for line, reason in NOT_RUN.items():
        assert reason, line
        if reason.startswith("tests/"):
            assert (repository / reason).exists(), (line, reason)


def test_what_the_lines_name_is_there(
    shown: dict[str, str], repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Options of commands, extras, make's targets, npm's scripts, programs."""
    project = tomllib.loads((repository / "pyproject.toml").read_text())["project"]
    targets = set(re.findall(r"^([a-z]+):", (repository / "Makefile").read_text(), re.MULTILINE))
    scripts = json.loads((repository / "web/package.json").read_text())["scripts"]
    helps: dict[str, str] = {}
    commands = COMMANDS.keys() | {each.name for each in entry_points(group=GROUP)}
    for line in shown:
        words = shlex.split(re.sub(r"^([A-Z_]+=\S+ )+", "", line))
        if words[0] == "breastrig" and words[1] != "COMMAND":
            assert words[1] in commands, line
            options = [word for word in words[2:] if word.startswith("-")]
            verb = words[2:3] if words[1] in ("audit", "case", "model", "cohort", "presets") and options else []
            command = " ".join([words[1], *verb])
            if options and command not in helps:
                with pytest.raises(SystemExit):
                    main([*command.split(), "--help"])
                helps[command] = capsys.readouterr().out
            for option in options:
                assert re.search(rf"(?<![\w-]){re.escape(option)}(?![\w-])", helps[command]), (line, option)
        elif "pip" in words[0]:
            for extras in re.findall(r"\[([\w,]+)\]", line):
                assert set(extras.split(",")) <= project["optional-dependencies"].keys(), line
        elif words[0] == "make":
            assert words[1] in targets, line
        elif words[0] == "npm" and "run" in words and words[-1] != "run":
            assert words[words.index("run") + 1] in scripts, line
        elif words[0] == "python" and words[1].endswith(".py"):
            assert (repository / words[1]).is_file(), line


def test_they_run_as_they_are_shown(repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = repository / "model_assets" / "example"
    write_example_fits(tmp_path / "made")
    for stance in ("standing", "supine"):
        shutil.copy(example / stance / "scan.ply", tmp_path / f"{stance}.ply")
    shutil.copy(tmp_path / "standing.ply", tmp_path / "scan.ply")
    shutil.copy(example / "standing" / "landmarks.json", tmp_path)
    for name in ("plan", "surgeon", "model"):
        shutil.copy(tmp_path / "made" / "standing" / "drawing.json", tmp_path / f"{name}.json")
    Storage(tmp_path / "data").prepare()
    blank_pictures(monkeypatch)
    monkeypatch.chdir(tmp_path)
    for line, stance in SHARED.items():
        shutil.copytree(tmp_path / "made" / stance, tmp_path / shlex.split(line)[-1])
    for shown_line, lines in RUN.items():
        for line in lines or [shown_line]:
            try:
                code = main(shlex.split(line)[1:])
            except SystemExit as left:
                code = left.code or 0
            assert code == 0, line


def test_the_documented_backup_holds_all_patients_and_nothing_that_opens_a_link(
    repository: Path, tmp_path: Path
) -> None:
    """Made while a server holds the folder and another program writes into it."""
    assert f"`{BACKUP}`" in (repository / "docs/how-to/own_server.md").read_text()
    storage, backup = Storage(tmp_path / "DATA"), Storage(tmp_path / "BACKUP")
    storage.prepare()
    case = new_case(storage.root / "cases")
    scan = new_scan(case)
    new_fit(case, scan)
    link = new_link(case)
    put_plan(case, [note(scan, "kept")])
    storage.index.look()
    with storage.index.writing() as rows:
        put_secret(rows, LinkSecret(link, "ab" * 32, "scrypt$of$a$passcode"))
    stop = threading.Event()

    def write() -> None:
        while not stop.is_set():
            put_plan(case, [note(scan, "kept")])

    writer = threading.Thread(target=write)
    writer.start()
    try:
        subprocess.run(BACKUP, shell=True, cwd=tmp_path, check=True, stderr=subprocess.DEVNULL)
    finally:
        stop.set()
        writer.join()
    backup.prepare()
    [patient] = listed_page(backup, 9, None)[0]
    assert get_plan(backup, patient.id).items[0]["text"] == "kept"
    assert [fit.state for fit in fits_page(backup, 9)[0]] == ["done"]
    assert backup.index.asked(secret_of_link, link) is None
    storage.close()
    backup.close()
    assert b"scrypt" in kept_below(storage.root)
    assert b"scrypt" not in kept_below(backup.root)

"""Fixtures that every test may use, one BLAS thread, rare garbage collection, and signals as on a terminal.

One thread: at the sizes of this project more are slower, and times and last digits wander.
Modules and thousands of collected tests last as long as the process; they are looked through once instead of over and
over, and young objects more rarely than elsewhere: of every 80 s of work 6 went into that, now 3.
A shell starts what runs in the background with SIGINT ignored, and programs that tests start would inherit that.
"""

import gc
import os
import signal
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg  # noqa: F401  loads SciPy's own BLAS, so that the limit below meets it too
from threadpoolctl import threadpool_limits

from breastrig.rig.model import Rig

gc.set_threshold(50_000, 20, 20)
threadpool_limits(limits=1)  # this process
os.environ["OPENBLAS_NUM_THREADS"] = "1"  # and those that tests start

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

REPOSITORY = Path(__file__).resolve().parents[1]

# What takes longest begins first, so that no worker is left with it at the end: by seconds, most of them first; where
# work waits for servers its seconds count too.
LONGEST = (
    "workflow/test_verdict_of_fits.py",
    "api/test_reports.py",
    "studies/test_evaluate.py",
    "scale/test_both_installations.py",
    "api/test_real_server.py",
    "examples/test_examples.py",
    "api/test_fuzz_http.py",
    "service/test_queue.py",
    "api/test_web_server.py",
    "workflow/test_fuzz_bodies.py",
    "workflow/test_scan_orientation.py",
    "colour/test_ink_on_painted_skin.py",
    "cli/test_serve_command.py",
    "interface/test_fit_interface.py",
    "cli/test_without_unix_and_server.py",
    "execution/test_dask_pool.py",
    "api/test_real_fit.py",
    "studies/test_studies.py",
    "faults/test_killed_server.py",
    "studies/virtual/test_make_virtual_cohort.py",
    "cli/test_report_command.py",
    "fitting/test_robustness.py",
    "cli/test_fit_command.py",
    "studies/virtual/test_make_warped.py",
    "studies/test_transfer.py",
    "load/test_load.py",
    "service/test_warm_scans.py",
    "colour/features/test_nipple.py",
    "drawings/test_live_pattern.py",
    "cli/test_outputs.py",
    "interface/test_pair_and_transfer.py",
    "cli/test_transfer_command.py",
    "scan/test_fuzz.py",
    "load/test_share_readers.py",
    "fitting/test_observation_weights.py",
    "scan/test_table.py",
    "api/test_transfers.py",
    "packaging/test_wheel.py",
    "fitting/test_recover_truth.py",
    "contracts/test_readme.py",
    "api/test_shares.py",
    "storage/test_deletion.py",
    "fitting/picks/test_wrong_picks.py",
    "service/test_pairs.py",
    "scan/test_points.py",
    "api/test_scans.py",
    "storage/test_data_folder.py",
    "cli/test_interruption.py",
    "execution/test_pool.py",
    "colour/test_find_ink.py",
    "fitting/test_propose.py",
    "studies/virtual/test_warped_bodies.py",
    "colour/test_areolae.py",
    "api/test_drawing_limits.py",
    "service/test_proposals.py",
    "scan/test_fuzz_inside.py",
    "api/test_fits.py",
    "report/test_measures.py",
    "fitting/test_orientation.py",
    "workflow/test_kept_scan.py",
    "studies/test_colour_landmarks.py",
    "fitting/body/test_relief.py",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files of LONGEST first, the others as they were found."""
    rank = {REPOSITORY / "tests" / name: place for place, name in enumerate(LONGEST)}
    assert all(path.is_file() for path in rank), "LONGEST names a file that is not there any more"
    items.sort(key=lambda item: rank.get(item.path, len(rank)))


def pytest_collection_finish() -> None:
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def remembered_uploads(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Tells this process and those that it starts where helpers.remembered_uploads has its files."""
    folder = tmp_path_factory.getbasetemp()
    shared = folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder
    os.environ["BREASTRIG_REMEMBERED_UPLOADS"] = str(shared / "remembered_uploads")


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers that are the same in every run."""
    return np.random.default_rng(20_240_511)


@pytest.fixture(scope="session")
def toy_rig() -> Rig:
    """A small rig made in memory: the same form as ours, a hundredth of its size."""
    from helpers.toy_rig import toy_rig as make_toy_rig

    return make_toy_rig()


@pytest.fixture(scope="session")
def repository() -> Path:
    """The root of the checkout (or of the unpacked sdist)."""
    return REPOSITORY

"""Parts of SciPy loaded alone: the same classes and numbers as from its packages, and most of it stays unloaded."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
import scipy.spatial
from helpers.bare_example import write_bare_example

from breastrig.core import scipy_parts
from breastrig.core.scipy_parts import LinAlgError, cholesky, csc_array, solve_lower, symmetric_factor


def said_by(program: str) -> list[str]:
    """The words that a Python of its own prints."""
    command = [sys.executable, "-W", "error", "-c", program]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()


def loaded_by(program: str) -> set[str]:
    """The modules that are there after it."""
    return set(said_by(f"import sys\n{program}\nprint(*sys.modules)"))


def test_a_fit_needs_neither_the_rest_of_scipy_nor_trimesh() -> None:
    slow = {"scipy.linalg", "scipy.special", "scipy.spatial", "scipy.sparse.linalg"}
    slow |= {"trimesh", "networkx", "matplotlib", "flask", "sqlalchemy"}
    assert not slow & loaded_by("import breastrig.cli.fit_command")


def test_a_whole_fit_of_a_scan_without_colours_needs_none_of_it_either(tmp_path: Path) -> None:
    scan, out = write_bare_example("standing", tmp_path / "scan.ply"), tmp_path / "out"
    program = f"from breastrig.cli.main import main\nassert main(['fit', {str(scan)!r}, '-o', {str(out)!r}]) == 0"
    slow = {"scipy.linalg", "scipy.special", "scipy.spatial", "scipy.sparse.linalg", "trimesh", "networkx", "PIL"}
    slow |= {"skimage", "breastrig.colour"}
    assert not slow & loaded_by(program)


def test_colours_are_looked_at_without_the_rest_of_scipys_trees() -> None:
    assert "scipy.spatial" not in loaded_by("import breastrig.colour.features.observe")


def test_pillows_formats_are_loaded_with_what_draws_an_uploads_picture() -> None:
    """By the fork server: an upload's process ends with its scan, and would load them anew for each."""
    assert "PIL.PngImagePlugin" in loaded_by("import breastrig.workflow.read_upload")


def test_a_fit_needs_neither_numpys_fortran_translator_nor_its_tools_for_tests() -> None:
    slow = {"numpy.f2py", "numpy.testing", "numpy.ma", "numpy.polynomial", "unittest"}
    assert not slow & loaded_by("import breastrig.cli.fit_command")


def test_a_server_itself_loads_nothing_of_what_its_tasks_compute_with() -> None:
    slow = {"scipy.ndimage", "scipy.linalg", "scipy.special", "scipy.spatial", "trimesh", "skimage", "PIL", "embreex"}
    slow |= {
        "pygltflib",
        "breastrig.fitting.fit",
        "breastrig.correspondence",
        "breastrig.scan.read",
        "breastrig.colour",
    }
    assert not slow & loaded_by("import breastrig.cli.serve_command")


def test_numpy_lists_all_of_its_names_afterwards() -> None:
    names = "print(*sorted(numpy.__all__), *sorted(dir(numpy)))\nassert numpy.ma.masked_array and numpy.f2py"
    assert said_by(f"import numpy, breastrig.core.scipy_parts\n{names}") == said_by(
        f"import numpy, scipy.sparse\n{names}"
    )


@pytest.mark.parametrize("order", [("breastrig.core.scipy_parts", "scipy.spatial"), ("scipy.spatial", "scipy.linalg")])
def test_the_parts_are_those_of_the_packages_whoever_is_imported_first(order: tuple[str, str]) -> None:
    program = (
        f"import pickle, {order[0]}, {order[1]}, scipy.spatial, scipy.linalg.lapack\n"
        "import breastrig.core.scipy_parts as parts\n"
        "assert parts.cKDTree is scipy.spatial.cKDTree\n"
        "assert parts.lapack.dpotrf is scipy.linalg.lapack.dpotrf\n"
        "assert pickle.loads(pickle.dumps(parts.cKDTree([[0.0]]))).n == 1\n"
        "print('yes')"
    )
    assert said_by(program) == ["yes"]


def test_where_scipy_is_arranged_in_another_way_its_public_modules_are_used(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("scipy.linalg._moved", "scipy.moved.deep"):
        assert scipy_parts._alone(name, "scipy.linalg.lapack", "dpotrf") is scipy.linalg.lapack
        assert name not in sys.modules
    matrix = csc_array([[4.0, 1.0], [1.0, 3.0]])
    monkeypatch.setattr(scipy_parts, "_alone", lambda *_: scipy.sparse.linalg)
    np.testing.assert_allclose(matrix @ symmetric_factor(matrix).solve(np.array([1.0, 2.0])), [1.0, 2.0], rtol=1e-14)


def definite(size: int) -> np.ndarray:
    rng = np.random.default_rng(3)
    half = rng.normal(size=(size, size))
    return half @ half.T + np.eye(size)


def test_factors_are_those_of_scipy() -> None:
    matrix, right = definite(30), np.arange(30.0)
    factor, public = cholesky(matrix), scipy.linalg.cholesky(matrix, lower=True)
    np.testing.assert_array_equal(np.tril(factor), public)
    for transposed in (False, True):
        wanted = scipy.linalg.solve_triangular(public, right, lower=True, trans=int(transposed))
        np.testing.assert_allclose(solve_lower(factor, right, transposed), wanted, rtol=1e-12)
    sparse = csc_array(np.where(np.abs(matrix) > 6.0, matrix, 0.0) + 100.0 * np.eye(30))
    options = {"SymmetricMode": True}
    library = scipy.sparse.linalg.splu(sparse, permc_spec="MMD_AT_PLUS_A", options=options)
    np.testing.assert_allclose(symmetric_factor(sparse).solve(right), library.solve(right), rtol=1e-13)


def test_a_matrix_that_is_not_positive_definite_is_refused() -> None:
    assert LinAlgError is scipy.linalg.LinAlgError
    with pytest.raises(LinAlgError, match="not positive definite"):
        cholesky(np.diag([1.0, -1.0]))
    assert cholesky(np.zeros((0, 0))).shape == (0, 0)
    assert solve_lower(np.zeros((0, 0)), np.zeros(0)).shape == (0,)

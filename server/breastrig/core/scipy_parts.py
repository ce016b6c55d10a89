"""The parts of SciPy that a fit needs, without the rest of it: sparse arrays, k-d trees, LAPACK and SuperLU.

Importing `scipy.linalg`, `scipy.spatial` and `scipy.sparse.linalg` takes three times as long as a fit's own arithmetic,
and a command, a worker and the server pay for it at each start.  These packages import all their modules (special
functions, rotations, eigenvalue solvers), of which a fit calls three that are compiled: they are loaded alone.
`scipy.sparse` is needed whole, but it copies all names of NumPy, and so loads NumPy's Fortran translator, test tools
and masked arrays, which take longer than itself: it is shown a NumPy of the names that are there already.

Where a future SciPy has arranged its modules in another way, the public ones are imported as usual; it takes longer
and computes the same.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from breastrig.core.arrays import Array

PANEL = 4  # columns that SuperLU takes together: a fit's matrices are narrow, the usual 10 take a third longer


@contextmanager
def _numpy_as_loaded() -> Iterator[None]:
    """NumPy names to those who list them only what is loaded of it; whatever is asked for by name is loaded as ever."""
    names: dict[str, Any] = vars(np)
    listed, loaded = {name: names[name] for name in ("__all__", "__dir__")}, sorted(names)
    names |= {"__all__": [name for name in np.__all__ if name in names], "__dir__": lambda: loaded}
    try:
        yield
    finally:
        names |= listed


def _alone(name: str, public: str, needed: str) -> Any:
    """A compiled module of SciPy without the package around it; the public module where there is no such one."""
    if name in sys.modules:
        return sys.modules[name]
    package = name.split(".")[1:-1]
    spec = PathFinder.find_spec(name, ["/".join([sys.modules["scipy"].__path__[0], *package])])
    if public in sys.modules or spec is None or spec.loader is None:
        return import_module(public)
    module = module_from_spec(spec)
    sys.modules[name] = module  # who imports the package later finds this one and its classes
    try:
        spec.loader.exec_module(module)
        getattr(module, needed)
    except (ImportError, AttributeError):
        sys.modules.pop(name, None)
        return import_module(public)
    return module


if TYPE_CHECKING:
    from scipy.linalg import lapack
    from scipy.sparse import coo_array, csc_array, csr_array, diags_array
    from scipy.spatial import cKDTree
else:
    with _numpy_as_loaded():
        from scipy.sparse import coo_array, csc_array, csr_array, diags_array

    cKDTree = _alone("scipy.spatial._ckdtree", "scipy.spatial", "cKDTree").cKDTree
    lapack = _alone("scipy.linalg._flapack", "scipy.linalg.lapack", "dpotrf")

LinAlgError = np.linalg.LinAlgError  # SciPy's is the same

__all__ = [
    "Factor",
    "LinAlgError",
    "cKDTree",
    "cholesky",
    "coo_array",
    "csc_array",
    "csr_array",
    "diags_array",
    "lapack",
    "solve_lower",
    "symmetric_factor",
]


def cholesky(matrix: Array) -> Array:
    """The lower factor L of a symmetric positive definite (N, N) matrix L Lᵀ; LinAlgError for any other.

    What stands above the diagonal is neither read nor cleared.  By LAPACK itself: SciPy's wrapper takes longer to check
    a fit's small matrices than to factor them.
    """
    if not len(matrix):
        return matrix
    factor, info = lapack.dpotrf(matrix, lower=1, clean=0)
    if info:
        raise LinAlgError("The matrix is not positive definite.")
    return np.asarray(factor)


def solve_lower(factor: Array, right: Array, transposed: bool = False) -> Array:
    """L⁻¹ right or L⁻ᵀ right, for (N, N) L of which the lower half is read, and (N,) or (N, M) right."""
    if not len(factor):
        return right
    return np.asarray(lapack.dtrtrs(factor, right, lower=1, trans=int(transposed))[0])


class Factor(Protocol):
    """A factored sparse matrix."""

    def solve(self, right: Array, /) -> Array:
        """The solution for (N,) or (N, M) right."""


def symmetric_factor(matrix: "csc_array") -> Factor:
    """SuperLU's factors of a symmetric positive definite (N, N) matrix, ordered by minimum degree."""
    options = {"SymmetricMode": True, "ColPerm": "MMD_AT_PLUS_A", "PanelSize": PANEL}
    superlu = _alone("scipy.sparse.linalg._dsolve._superlu", "scipy.sparse.linalg", "gstrf")
    if hasattr(superlu, "gstrf"):
        matrix.sum_duplicates()
        arrays = matrix.data, matrix.indices.astype(np.intc, copy=False), matrix.indptr.astype(np.intc, copy=False)
        try:
            factor: Factor = superlu.gstrf(
                matrix.shape[1], matrix.nnz, *arrays, csc_construct_func=type(matrix), ilu=False, options=options
            )
        except TypeError:  # another signature
            pass
        else:
            return factor
    public: Any = import_module("scipy.sparse.linalg")
    factor = public.splu(matrix, permc_spec="MMD_AT_PLUS_A", options=options)
    return factor

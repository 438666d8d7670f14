"""Direct solvers for symmetric positive definite systems.

CHOLMOD (scikit-sparse 0.4.16 on libsuitesparse) is used where it is installed; SuperLU, which comes with
SciPy, is the fallback. A field names the one that ran.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.mesh.triangle import Floats

FREE_TO_MOVE = "the part is free to move: hold it on its outer boundary or choose another support"


class Factor(Protocol):
    """A factorised matrix."""

    name: str

    def solve(self, right: Floats) -> Floats:
        """The solution for one right-hand side (n,) or several (n, k)."""
        ...

    def work(self, right: Floats) -> Floats:
        """fᵀ K⁻¹ f (k,) of each of several right-hand sides (n, k)."""
        ...

    def onto_seams(self, forces: sp.csc_matrix) -> sp.csc_matrix:
        """Few forces (n, k) as the s unknowns that were factorised feel them, (s, k)."""
        ...

    def solve_seams(self, on_seams: Floats) -> Floats:
        """The motion of those unknowns under what they feel, (s, k)."""
        ...

    def from_seams(self, motion: Floats, forces: Floats) -> Floats:
        """The whole solution (n,) from theirs (s,) and the forces (n,)."""
        ...

    def inside(self, left: sp.csc_matrix, right: sp.csc_matrix) -> Floats:
        """leftᵀ K⁻¹ right (r, k) of few forces (n, r) and (n, k) while those unknowns are held."""
        ...


class _Whole(ABC):
    """A factor of all unknowns: none are left inside."""

    @abstractmethod
    def solve(self, right: Floats) -> Floats:
        """See `Factor`."""

    def work(self, right: Floats) -> Floats:
        """See `Factor`."""
        return np.einsum("nk,nk->k", right, self.solve(right))

    def onto_seams(self, forces: sp.csc_matrix) -> sp.csc_matrix:
        """See `Factor`."""
        return forces

    def solve_seams(self, on_seams: Floats) -> Floats:
        """See `Factor`."""
        return self.solve(on_seams)

    def from_seams(self, motion: Floats, forces: Floats) -> Floats:
        """See `Factor`."""
        return motion

    def inside(self, left: sp.csc_matrix, right: sp.csc_matrix) -> Floats:
        """See `Factor`."""
        return np.zeros_like((left.T @ right).toarray())


class Cholmod(_Whole):
    """Sparse Cholesky by CHOLMOD, given the lower triangle."""

    name = "CHOLMOD"

    def __init__(self, lower: sp.csc_matrix) -> None:
        module = cholmod()
        assert module is not None
        try:
            self._factor: Any = module.cholesky(lower)
        except module.CholmodNotPositiveDefiniteError as error:
            raise AnalysisError(FREE_TO_MOVE) from error

    def solve(self, right: Floats) -> Floats:
        """See `Factor`."""
        return self._factor(right)


class SuperLU(_Whole):
    """Sparse LU by SuperLU in its symmetric mode, given the lower triangle."""

    name = "SuperLU"

    def __init__(self, lower: sp.csc_matrix) -> None:
        strict = sp.tril(lower, -1, format="csc")
        whole = (strict + strict.T + sp.diags_array(lower.diagonal())).tocsc()
        try:
            self._factor: Any = splu(
                whole, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError as error:  # "Factor is exactly singular"
            raise AnalysisError(FREE_TO_MOVE) from error
        except MemoryError as error:  # the fill is beyond SuperLU's 32-bit indices
            raise AnalysisError(
                f"{whole.shape[0]} unknowns are too many for SuperLU: install scikit-sparse==0.4.16, "
                "or take a lower version or a plainer style"
            ) from error

    def solve(self, right: Floats) -> Floats:
        """See `Factor`."""
        return self._factor.solve(np.asarray(right))


@cache
def cholmod() -> ModuleType | None:
    """scikit-sparse's CHOLMOD module, or None where it is not installed."""
    try:
        return import_module("sksparse.cholmod")
    except ImportError:
        return None


def factorise(lower: sp.csc_matrix, solver: str | None = None) -> Factor:
    """Factorise a symmetric positive definite matrix given by its lower triangle.

    `solver` is "CHOLMOD", "SuperLU" or None for the best one installed.

    Raises:
        AnalysisError: the matrix is singular, or the solver is not there.
    """
    if solver not in (None, Cholmod.name, SuperLU.name):
        raise AnalysisError(f"solver {solver!r} is unknown; choose {Cholmod.name} or {SuperLU.name}")
    if solver == SuperLU.name or (solver is None and cholmod() is None):
        return SuperLU(lower)
    if cholmod() is None:
        raise AnalysisError(
            "CHOLMOD is not installed: pip install scikit-sparse==0.4.16, or leave the solver to choose"
        )
    return Cholmod(lower)

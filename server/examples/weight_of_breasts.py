"""How far a breast's own weight moves it, by scikit-fem: linear elasticity, one stiffness, everything behind the chest
wall held.  A first look at the mesh, not a prediction (`breastrig predict` has the large deformations).

    breastrig volume OUT -o torso.msh
    python weight_of_breasts.py torso.msh mm 0 0 -1          (the scan's unit, and where down is in its frame)
"""

import sys

import numpy as np
from skfem import Basis, ElementTetP1, ElementVector, LinearForm, Mesh, condense, solve
from skfem.models.elasticity import lame_parameters, linear_elasticity

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}
YOUNG, POISSON, WEIGHT = 3000.0, 0.45, 9810.0  # Pa, 1, N/m³


def main(file: str, unit: str, *down: str) -> None:
    mesh = Mesh.load(file).scaled(METRES[unit])
    basis = Basis(mesh, ElementVector(ElementTetP1()))
    pull = WEIGHT * np.array(down, dtype=float)
    weight = LinearForm(lambda v, w: pull[0] * v[0] + pull[1] * v[1] + pull[2] * v[2]).assemble(basis)
    stiffness = linear_elasticity(*lame_parameters(YOUNG, POISSON)).assemble(basis)
    held = np.unique(mesh.t[:, np.concatenate([mesh.subdomains["chest_wall"], mesh.subdomains["trunk"]])])
    moved = solve(*condense(stiffness, weight, D=basis.nodal_dofs[:, held].ravel()))[basis.nodal_dofs]
    for side in "LR":
        breast = np.unique(mesh.t[:, mesh.subdomains[f"breast_{side}"]])
        print(f"breast_{side}: up to {1e3 * np.linalg.norm(moved[:, breast], axis=0).max():.1f} mm")


if __name__ == "__main__":
    main(*sys.argv[1:])

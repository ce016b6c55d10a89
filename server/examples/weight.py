"""The breast under its own weight.

The tetrahedra inside the fitted body go to scikit-fem without a file: linear elasticity, one stiffness,
everything behind the chest wall held. A first look at the mesh, not a prediction (`breastrig.predict` has the
large deformations).
"""

import numpy as np
from matplotlib import colormaps
from PIL import Image
from skfem import Basis, ElementTetP1, ElementVector, LinearForm, MeshTet, condense, solve
from skfem.models.elasticity import lame_parameters, linear_elasticity

import breastrig

YOUNG, POISSON, WEIGHT = 3000.0, 0.45, 9810.0  # Pa, 1, N/m³


def main() -> Image.Image:
    fit = breastrig.fit(*breastrig.example("standing"))
    inside = breastrig.volume_mesh(fit)
    print(inside)

    mesh = MeshTet(fit.metres_per_unit * inside.points.T, inside.tetrahedra.T)
    basis = Basis(mesh, ElementVector(ElementTetP1()))
    pull = -WEIGHT * fit.frame.up
    weight = LinearForm(lambda v, w: pull[0] * v[0] + pull[1] * v[1] + pull[2] * v[2]).assemble(basis)
    stiffness = linear_elasticity(*lame_parameters(YOUNG, POISSON)).assemble(basis)
    behind = [inside.regions.index(name) for name in ("chest_wall", "trunk")]
    held = np.unique(inside.tetrahedra[np.isin(inside.region, behind)])
    moved = solve(*condense(stiffness, weight, D=basis.nodal_dofs[:, held].ravel()))[basis.nodal_dofs].T
    mm = 1e3 * np.linalg.norm(moved, axis=1)[: len(fit.vertices)]  # the skin's nodes come first
    for side in "LR":
        print(f"breast_{side}: up to {mm[fit.model.regions[f'breast_{side}']].max():.1f} mm")

    colours = colormaps["viridis"](mm / mm.max())[:, :3]
    return fit.model.picture(fit.vertices, unit=fit.unit, view="three_quarter", colours=colours, size=(480, 560))


if __name__ == "__main__":
    main().save("weight.png")

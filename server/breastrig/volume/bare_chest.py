"""The skin that a body would have without its breasts: a linear map from places on the trunk around them."""

from dataclasses import dataclass

from breastrig.core.arrays import Array, Integers


@dataclass(frozen=True, eq=False)
class BareChest:
    """One rig's map to the skin without breasts, estimated by model_assets/make_volume.py (docs/decisions/0021)."""

    under: Integers  # (U,) vertices that a breast lifts
    share: Array  # (U,) 1 under its base, 0 where it ends
    around: Integers  # (A,) vertices that say where the chest is
    weights: Array  # (U, A)

    def of(self, vertices: Array) -> Array:
        """(V, 3) m: a body without its breasts."""
        result, middle = vertices.copy(), vertices[self.around].mean(axis=0)
        bare = middle + self.weights @ (vertices[self.around] - middle)
        result[self.under] += self.share[:, None] * (bare - result[self.under])
        return result

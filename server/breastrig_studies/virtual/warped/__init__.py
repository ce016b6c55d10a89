"""Warped bodies: many synthetic patients with known truth, made from few sources, to choose constants by.

Each is the true skin of a source body, standing and lying, under changed proportions (segments of the trunk, navel,
folds, shoulders, breasts, hips, one-sided changes, the mastectomy of one side) and a smooth random warp. The change is
defined on the standing skin and transferred to the lying one, so that both correspond vertex by vertex; landmarks are
points of the skin. The bodies are made in two halves that share no source: choose on one, report on the other.
"""

from breastrig_studies.virtual.warped.make import make_warped

__all__ = ["make_warped"]

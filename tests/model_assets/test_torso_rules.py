"""The rules for the package's own torso find what is no whole torso."""

from dataclasses import replace

import numpy as np
from torso_rules import torso_findings

from breastrig.rig.model import Rig
from breastrig.rig.validation.finding import Finding


def broken_rules(rig: Rig) -> dict[str, Finding]:
    return {finding.name: finding for finding in torso_findings(rig) if not finding.ok}


def test_the_packages_torso_must_be_a_whole_torso(toy_rig: Rig) -> None:
    broken = broken_rules(toy_rig)
    assert {
        "the size is right",
        "it has the nine bones",
        "it has the twelve landmarks",
        "it has the drawing anatomy",
        "it has the drawing lumpectomy",
        "it has the drawing mastectomy",
        "every line has its partner",
        "it has 55 shapes",
        "the shapes cover breast and body",
        "waist, neck and arms are open",
        "landmarks are where a body has them",
    } <= set(broken)
    assert all(finding.severity == "error" for finding in broken.values())


def test_a_breast_shape_that_moves_the_other_breast_is_caught(toy_rig: Rig) -> None:
    both = toy_rig.blendshapes.copy()
    both[0] += both[1]
    broken = broken_rules(replace(toy_rig, blendshapes=both))
    assert "bump_L" in broken["each breast has its own shapes"].detail


def test_each_areola_of_the_packages_torso_has_round_rings_about_a_vertex(torso: Rig) -> None:
    areolas = ["areola and nipple_L have rings of edges", "areola and nipple_R have rings of edges"]
    assert not set(areolas) & set(broken_rules(torso))
    between = [replace(each, barycentric=np.array([0.4, 0.3, 0.3])) for each in torso.landmarks]
    for broken in (replace(torso, landmarks=tuple(between)), replace(torso, template=torso.template * [1.0, 2.0, 1.0])):
        assert set(areolas) <= set(broken_rules(broken))

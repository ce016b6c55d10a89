"""What the fork server makes ready before any fit is what fits then find."""

import importlib

from breastrig.energies import folding
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf import skinned
from breastrig.gltf.lines import ribbon
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig import vertex_groups
from breastrig.workflow import default_model
from breastrig.workflow.jobs import FitJob
from breastrig.workflow.scan_fit import fit_plan, read_model


def test_the_model_of_a_job_is_there_already_with_its_parts(tmp_path: object) -> None:
    importlib.reload(default_model)
    rig = read_model(FitJob(scan=tmp_path, out=tmp_path, landmarks_mm={}))  # type: ignore[arg-type]
    assert rig is read_rig(default_rig_path())
    known = (skinned._only_the_rig, vertex_groups.vertex_groups, ribbon.ribbons, folding.pressed_edges)
    before = [cache.cache_info().misses for cache in known]
    skinned.skinned_document(rig, {})
    vertex_groups.vertex_groups(rig)
    limits = load_recipe("default").shapes.folding
    assert limits is not None
    folding.pressed_edges(rig, limits.least)
    plan = fit_plan(FitJob(scan=tmp_path, out=tmp_path, landmarks_mm={}), rig, {})  # type: ignore[arg-type]
    assert plan.drawing is not None
    ribbon.ribbons(rig, plan.drawing.on_model(rig, rig.template))
    assert [cache.cache_info().misses for cache in known] == before

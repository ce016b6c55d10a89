"""Khronos' glTF validator finds no error and no warning in any kind of file that leaves the program."""

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.random_pose import random_parameters
from helpers.scan_files import picture
from helpers.toy_rig import toy_rig

from breastrig.gltf.iterate import drawing_buffer, iterate_gltf, model_buffer
from breastrig.gltf.lines.lines_glb import Ball, lines_glb, with_lines
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.gltf.replay import fitted_glb
from breastrig.gltf.write_rig import rig_glb
from breastrig.rig.model import Rig
from breastrig.rig.skinning import pose

WEB = Path(__file__).resolve().parents[2] / "web"


def validate(*files: Path) -> subprocess.CompletedProcess[str]:
    node = shutil.which("node")
    assert node, "Node is not on the path; make test puts it there."
    assert (WEB / "node_modules" / "gltf-validator").is_dir(), "gltf-validator is missing: run npm ci in web/."
    command = [node, str(WEB / "scripts" / "validate-gltf.mjs"), *map(str, files)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


LESION = Ball("lesion_a", np.array([0.1, 0.2, 0.3]), 0.008, (184, 50, 128), {"radius_mm": 8.0})


def all_files(rig: Rig, folder: Path) -> list[Path]:
    """One file of each kind for this rig."""
    rng = np.random.default_rng(7)
    poses = [random_parameters(rig, rng) for _ in range(4)]
    contents = {"model.glb": rig_glb(rig), "iteration_plain.gltf": iterate_gltf(rig, poses[0], None, "model.bin", None)}
    strokes = [("stroke", rig.template[:5], False, (200, 10, 0)), ("ring", rig.template[:9], True, (0, 0, 0))]
    contents["lines.glb"] = lines_glb([*strokes, ("spot", rig.template[:1], False, (1, 2, 3))])
    contents["model.bin"] = model_buffer(rig)
    contents["fitted_plain.glb"] = fitted_glb(rig, poses[:1], [0.0], None, {})
    for drawing in rig.drawings:
        lines = f"{drawing.name}.bin"
        contents[lines] = drawing_buffer(rig, drawing)
        contents[f"iteration_{drawing.name}.gltf"] = iterate_gltf(rig, poses[1], drawing, "model.bin", lines)
        contents[f"fitted_{drawing.name}.glb"] = fitted_glb(rig, poses, [0.0, 0.1, 0.1, 0.3], drawing, {"a": 1})
        contents[f"planned_{drawing.name}.glb"] = with_lines(contents[f"fitted_{drawing.name}.glb"], strokes, [LESION])
        skin = pose(rig, poses[-1]) + 0.004 * rng.normal(size=rig.template.shape)
        contents[f"layer_{drawing.name}.glb"] = fitted_glb(rig, poses, [0.0, 0.1, 0.1, 0.3], drawing, {}, skin)
    colours = rng.integers(0, 256, (len(rig.template), 3)).astype(np.uint8)
    far = np.array([10_000.5, -300.25, 7_000.125])
    away = [pose.moved(np.eye(3), far) for pose in poses]
    contents["lines_far.glb"] = lines_glb([("stroke", rig.template[:5] + far, False, (200, 10, 0))])
    contents["fitted_far.glb"] = fitted_glb(rig, away, [0.0, 0.1, 0.2, 0.3], rig.drawings[0], {})
    contents["mesh_far.glb"] = mesh_glb(rig.template + far, rig.faces)
    contents["mesh.glb"] = mesh_glb(rig.template, rig.faces)
    contents["mesh_colours.glb"] = mesh_glb(rig.template, rig.faces, colours=colours)
    contents["mesh_texture.glb"] = mesh_glb(rig.template, rig.faces, uv=rig.uv, texture=picture("PNG"))
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    return [folder / name for name in contents if not name.endswith(".bin")]


def test_every_kind_of_file_of_the_toy_rig_is_clean(tmp_path: Path) -> None:
    result = validate(*all_files(toy_rig(), tmp_path))
    assert result.returncode == 0, result.stderr


def test_every_kind_of_file_of_the_torso_is_clean(tmp_path: Path) -> None:
    torso = read_rig(default_rig_path())
    result = validate(default_rig_path(), *all_files(replace(torso, drawings=torso.drawings[:1]), tmp_path))
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("content", [b"glTF"])
def test_the_validator_is_really_asked(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "wrong.glb").write_bytes(content)
    assert validate(tmp_path / "wrong.glb").returncode == 1


def test_a_warning_fails_too(tmp_path: Path) -> None:
    text = iterate_gltf(toy_rig(), random_parameters(toy_rig(), np.random.default_rng(1)), None, "model.bin", None)
    (tmp_path / "model.bin").write_bytes(model_buffer(toy_rig()))
    # a skinned mesh below another node is a warning: viewers ignore its transform
    nodes = text.replace(b'"nodes":[{"mesh":0', b'"nodes":[{"translation":[1.0,0.0,0.0],"mesh":0', 1)
    assert nodes != text
    (tmp_path / "moved.gltf").write_bytes(nodes)
    result = validate(tmp_path / "moved.gltf")
    assert result.returncode == 1, result.stdout
    assert "warning" in result.stderr

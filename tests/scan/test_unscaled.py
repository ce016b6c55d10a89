"""Files of programs without a scale say so themselves; of all others nothing is guessed."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from helpers.mesh_variants import glb

from breastrig.core.errors import BadScan
from breastrig.core.glb import pack_glb, split_glb
from breastrig.core.picks import Length
from breastrig.scan.read import read_scan
from breastrig.scan.stored_scan import STORED, write_stored
from breastrig.scan.true_size import facts_in, true_size
from breastrig.scan.unscaled import UNKNOWN_SIZE, unscaled

SAYS = tuple(each.says for each in unscaled().programs)


def mesh(kind: str, size: float = 0.6) -> bytes:
    content = trimesh.creation.icosphere(subdivisions=2, radius=size / 2.0).export(file_type=kind)
    return content if isinstance(content, bytes) else content.encode()


def ply(says: str, size: float = 0.6) -> bytes:
    return mesh("ply", size).replace(b"element vertex", f"comment {says}\nelement vertex".encode(), 1)


def obj(says: str) -> bytes:
    return f"# \r\n# Wavefront OBJ file\r\n# {says}\r\n".encode() + mesh("obj")


def gltf(says: object) -> bytes:
    document, binary = split_glb(glb())
    return pack_glb(json.dumps(document | {"asset": {"version": "2.0", "generator": says}}).encode(), binary)


@pytest.mark.parametrize("make", [ply, obj, gltf])
def test_a_file_of_a_program_without_a_scale_has_no_known_size(make) -> None:
    for says in SAYS:
        assert not read_scan(make(says)).size_known
        assert not read_scan(make(f"{says} 2.3")).size_known
        assert read_scan(make(f"Not {says}")).size_known
    assert read_scan(make("Blender 4.2")).size_known


def test_what_begins_no_comment_of_the_header_says_nothing() -> None:
    assert read_scan(mesh("ply") + f"\ncomment {SAYS[0]}".encode()).size_known
    assert read_scan(mesh("obj") + f"# {SAYS[0]}\n".encode()).size_known, "only the beginning is looked at"
    assert read_scan(gltf([SAYS[0]])).size_known, "no text"


def test_it_is_kept_with_the_scan_and_ends_with_a_length(tmp_path: Path) -> None:
    scan = read_scan(ply(SAYS[0]))
    write_stored(scan, tmp_path / "scan")
    assert not read_scan(tmp_path / "scan", STORED, units="m").size_known
    assert SAYS[0].encode() not in (tmp_path / "scan").read_bytes()
    size = true_size(Length("a", "b", 103.0), {"a": np.zeros(3), "b": np.array([0.1, 0.0, 0.0])})
    assert scan.in_true_size(size).size_known
    facts = facts_in({"size_known": False, "notes": ["One.", UNKNOWN_SIZE]}, size)
    assert (facts["size_known"], facts["notes"]) == (True, ["One.", size.note])
    write_stored(replace(scan, size_known=True), tmp_path / "scan")
    assert read_scan(tmp_path / "scan", STORED, units="m").size_known


def test_a_size_that_no_torso_has_in_any_unit_says_what_to_do() -> None:
    with pytest.raises(BadScan, match=r"no torso in any unit; .* Its app has no scale: scale the scan there"):
        read_scan(ply(SAYS[0], 0.14))
    with pytest.raises(BadScan, match="no torso in any unit") as refused:
        read_scan(ply("Blender", 0.14))
    assert "Its app" not in str(refused.value)

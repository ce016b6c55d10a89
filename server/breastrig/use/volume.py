"""The inside of a fitted body, for programs."""

from dataclasses import dataclass
from pathlib import Path

from breastrig.core.arrays import Array, Integers, frozen
from breastrig.core.one_thread import one_thread
from breastrig.core.output_files import all_or_nothing, single_file
from breastrig.core.private_files import write_private
from breastrig.core.stances import SIDES
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.body_frame import body_frame
from breastrig.report.volume import breast_volume
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of
from breastrig.use.reports.report import ReportJob, stance_of
from breastrig.use.values.fit_result import Fit
from breastrig.use.values.model import Model
from breastrig.volume.mesh_files import Wanted, mesh_file
from breastrig.volume.tetrahedra import volume_mesh as tetrahedra_of
from breastrig.volume.volume_mesh import REGIONS, VolumeMesh


@dataclass(frozen=True, eq=False, repr=False)
class Volume:
    """N nodes and M tetrahedra in a fitted body, the same for all fits of a model; in the scan's unit and frame."""

    points: Array  # (N, 3); the first V are the model's vertices, on the skin
    tetrahedra: Integers  # (M, 4) positive by the right hand rule
    region: Integers  # (M,) indices of `regions`
    regions: tuple[str, ...]  # skin (with the fat under it), breast_L, breast_R, chest_wall, trunk; breasts down to
    # the pectoral muscle, some 12 mm deeper than the volumes of `measure`
    surface: Integers  # (F, 3) the skin's triangles, those of the model
    wall: Integers  # (F, 3) the chest wall's face, counter-clockwise from outside
    model_vertex: Integers  # (N,) the model's vertex, -1 for nodes that are not on the skin
    sets: dict[str, Integers]  # nodes by name: fixed, sliding, cuts, and what holds the breast: dense_*, loose_*
    depth: Array  # (N,) 0 on the skin, 1 on the chest wall and behind it, harmonic between
    scaled_jacobian: Array  # (M,) 1 for regular tetrahedra
    unit: str
    of_fit: FitFolder
    in_metres: VolumeMesh

    def save(self, file: str | Path, *, force: bool = False) -> None:
        """Writes .vtu or .msh (in the scan's unit, with the extra `volume`), .scn (SOFA) or .feb (FEBio; both SI).

        Raises BadInput; an earlier file is replaced by `force` only.
        """
        with all_or_nothing(single_file(Path(file), (), force)) as staging:
            write_private(staging / Path(file).name, volume_file(self.of_fit, self.in_metres, Path(file).name))

    def __repr__(self) -> str:
        return f"<Volume: {len(self.points)} nodes, {len(self.tetrahedra)} tetrahedra, in {self.unit}>"


def volume_mesh(fit: Fit | str | Path, model: Model = None) -> Volume:
    """Tetrahedra of a fit or of the folder of one, made in seconds, in the scan's unit and frame.

    The same nodes and tetrahedra for all fits of a model; `model` is that of a folder.

    Raises BadInput for a folder that is no fit, and for a model whose inside is not known.
    """
    found = (fit if isinstance(fit, Fit) else Fit.load(fit, model)).in_metres
    with one_thread():
        mesh = volume_of(found)
    return Volume(
        points=frozen(mesh.points / found.metres_per_unit),
        tetrahedra=mesh.tetrahedra,
        region=mesh.region,
        regions=REGIONS,
        surface=mesh.surface,
        wall=mesh.wall,
        model_vertex=mesh.model_vertex,
        sets=dict(mesh.node_sets),
        depth=mesh.depth,
        scaled_jacobian=frozen(mesh.scaled_jacobian),
        unit=found.unit,
        of_fit=found,
        in_metres=mesh,
    )


DOWN = {"standing": (1, -1.0), "supine": (2, -1.0), "prone": (2, 1.0)}  # axis of the body (left, up, front) and sign


def volume_of(fit: FitFolder) -> VolumeMesh:
    """In metres, in the scan's frame.  Raises BadInput for a rig whose inside is not known."""
    return tetrahedra_of(fit.rig, fit.parameters, fit.vertices)


def breasts_said(fit: FitFolder, mesh: VolumeMesh) -> str:
    """Why its breasts are larger than those of a report of the same fit; empty for a rig that has no report's."""
    stance = stance_of(fit)
    found = [breast_volume(stance, side) for side in SIDES]
    reported = [f"{1e6 * each.value:.0f}" for each in found if each is not None]
    inside = [f"{1e6 * mesh.volumes[mesh.inside(f'breast_{side}')].sum():.0f}" for side in SIDES]
    if len(reported) < len(SIDES):
        return ""
    return (
        f"Breasts, left and right: {' and '.join(inside)} ml in the mesh, down to the pectoral muscle; "
        f"{' and '.join(reported)} ml in a report, down to where the skin would be without them."
    )


def volume_file(fit: FitFolder, mesh: VolumeMesh, name: str) -> bytes:
    """The content of the file `name`, by its ending.  Raises BadInput."""
    axis, sign = DOWN[fit.stance]
    down = sign * body_frame(fit.rig, fit.vertices).axes[:, axis]
    return mesh_file(mesh, name, Wanted(fit.metres_per_unit, down))


def volume_vtu_of(job: ReportJob) -> bytes:
    """The file volume.vtu of the job's fit, for the service."""
    fit = fit_folder_of(job.fit, read_rig(job.model or default_rig_path()))
    return volume_file(fit, volume_of(fit), "volume.vtu")

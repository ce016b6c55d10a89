"""The inside of a fitted body, from its folder: tetrahedra for finite elements."""

from breastrig.core.stances import SIDES
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.body_frame import body_frame
from breastrig.report.volume import breast_volume
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of
from breastrig.use.reports.report import ReportJob, stance_of
from breastrig.volume.mesh_files import Wanted, mesh_file
from breastrig.volume.tetrahedra import volume_mesh
from breastrig.volume.volume_mesh import VolumeMesh

DOWN = {"standing": (1, -1.0), "supine": (2, -1.0), "prone": (2, 1.0)}  # axis of the body (left, up, front) and sign


def volume_of(fit: FitFolder) -> VolumeMesh:
    """In metres, in the scan's frame.  Raises BadInput for a rig whose inside is not known."""
    return volume_mesh(fit.rig, fit.parameters, fit.vertices)


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
    """volume.vtu of the job's fit: what the service's worker makes."""
    fit = fit_folder_of(job.fit, read_rig(job.model or default_rig_path()))
    return volume_file(fit, volume_of(fit), "volume.vtu")

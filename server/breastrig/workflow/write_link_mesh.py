"""The worker's side of one mesh for share links: from the file of the scan's mesh to the file that links show."""

from breastrig.core.errors import BadScan
from breastrig.core.private_files import write_private
from breastrig.gltf.link_mesh import coloured_mesh, plain_mesh
from breastrig.workflow.further_jobs import LinkMeshJob


def write_link_mesh(job: LinkMeshJob) -> None:
    """Raises BadScan with a sentence, OSError when it cannot be read or written."""
    make = coloured_mesh if job.has_colours else plain_mesh
    try:
        write_private(job.shown, make(job.mesh.read_bytes(), job.cuts))
    except MemoryError as error:
        raise BadScan("This scan is too large to be shown through a link; simplify it first.") from error

"""The worker's side of one plain mesh: from the file of the coloured mesh to the file without colours."""

from breastrig.core.errors import BadScan
from breastrig.core.private_files import write_private
from breastrig.gltf.plain_mesh import plain_mesh
from breastrig.workflow.further_jobs import PlainMeshJob


def write_plain_mesh(job: PlainMeshJob) -> None:
    """Raises BadScan with a sentence, OSError when it cannot be read or written."""
    try:
        write_private(job.plain, plain_mesh(job.mesh.read_bytes(), job.cuts))
    except MemoryError as error:
        raise BadScan("This scan is too large to be shown without its colours; simplify it first.") from error

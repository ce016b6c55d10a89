"""A cleaned scan made ready for a fit: the table under a lying patient cut away, to be indexed.

Upload, proposals, fits and evaluations all come through here, so that they look at the same skin.  What the upload has
found of the scan's directions is handed on with the scan and not looked for again.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.correspondence.target import ScanTarget
from breastrig.scan.background import cut_background, without_background
from breastrig.scan.clean import MIN_TRIANGLES, Surface, compact, large_pieces
from breastrig.scan.orient import Frame, propose_frame
from breastrig.scan.table import Table, found_table


@dataclass(frozen=True, eq=False)
class PreparedScan:
    """What is fitted to."""

    surface: Surface  # in the scan's own frame, table included, floors and walls not
    target: ScanTarget  # without the table
    table_triangles: int  # how many were cut away as table
    known_frame: Frame | None = None
    cut_away: float = 0.0  # m², of floors and walls

    @cached_property
    def frame(self) -> Frame:
        """Front and stance as they are seen on the whole scan."""
        return self.known_frame or propose_frame(self.surface.vertices, self.surface.faces)

    @property
    def notes(self) -> tuple[str, ...]:
        """One sentence for each thing that was done."""
        if not self.table_triangles:
            return self.surface.notes
        return (*self.surface.notes, f"{self.table_triangles} triangles of the table under the patient were left out.")


def prepared(surface: Surface, stance: str, frame: Frame | None = None) -> PreparedScan:
    """The scan of a patient in this stance (auto | standing | supine); `frame` when it is known already.

    A table is looked for unless she stands; one that is seen behind the body says that she lies.  Floors and walls are
    cut away where nobody has said that she stands, or where it is known that there are some.
    """
    cut_away, table = 0.0, None
    if stance != "standing" or (frame is not None and frame.background):
        surface, frame, cut_away, table = _without_background(surface, frame)
    vertices, faces, cut, plane = surface.vertices, surface.faces, 0, None
    if stance != "standing" and frame is not None and frame.table is not None:
        table = table or found_table(vertices, faces, *frame.table)
        body = ~table.triangles
        if not body.all() and np.count_nonzero(body) >= MIN_TRIANGLES:
            plane = table.plane
            kept = faces[body]
            kept = kept[large_pieces(vertices, kept)[0]]  # without what curled up at the table's edge
            cut = len(faces) - len(kept)
            vertices, faces = compact(vertices, kept)
    return PreparedScan(surface, ScanTarget(vertices, faces, table=plane), cut, frame, cut_away)


def _without_background(surface: Surface, frame: Frame | None) -> tuple[Surface, Frame, float, Table | None]:
    """The surface without floors and walls, how it is seen then, the area (m²) of what was cut, and a table found."""
    vertices, faces = surface.vertices, surface.faces
    if frame is not None and not frame.background:
        return surface, frame, 0.0, None
    found = without_background(vertices, faces) if frame is None else cut_background(vertices, faces, frame)
    if not found.frame.background:
        return surface, found.frame, 0.0, found.table
    note = f"A floor or wall and what stood by it were cut away: {1e4 * found.area:,.0f} cm²."
    return Surface(*compact(vertices, found.faces), (*surface.notes, note)), found.frame, found.area, None

"""The painted skin as a scanning program's texture shows it: light, exposure of each view, blur, noise and JPEG.

Colours are taken from slightly beside the place (views are believed to be from elsewhere), as on real scans.
"""

import io
from dataclasses import dataclass

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.rays import RayCaster
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.painted.albedo import Albedo
from breastrig_studies.virtual.painted.atlas import Atlas
from breastrig_studies.virtual.scan import SimulatedScan

SMALL_RAYS = 48  # for how much of the room a place sees
ROOM = 0.25  # m; skin nearer than this hides the room
LIFT = 0.002  # m off the skin, where such rays begin
AMBIENT = (0.40, 0.60)  # share of the light that comes from everywhere
MISPLACED = 0.0005  # m on each axis, standard deviation; up to 1 mm
BLUR = (0.5, 1.2)  # texels
QUALITY = (80, 91)  # JPEG
BESIDE = 0.012  # m from the true skin; farther is table
SHEET = (0.30, 0.42, 0.45)  # linear red, green, blue of its cover
VIEWS = 6
EXPOSURE = 0.025  # standard deviation of the views' brightness


@dataclass(frozen=True, eq=False)
class Photograph:
    """A texture and how it was made."""

    jpeg: bytes
    blur: float  # texels
    quality: int


def photograph(
    albedo: Albedo,
    standing: Array,
    body: VirtualBody,
    faces: Integers,
    scan: SimulatedScan,
    atlas: Atlas,
    random: np.random.Generator,
) -> Photograph:
    """The photograph of a body in its stance, whose skin (V, 3) `standing` m, (F, 3) `faces` is painted."""
    found = ClosestPointSearch(body.vertices, faces).query(scan.vertices)
    there = np.einsum("mc,mcd->md", found.barycentric, standing[faces[found.faces]])  # on the standing skin
    open_sky = _open_sky(body.vertices, faces, random)
    sky = np.einsum("mc,mc->m", found.barycentric, open_sky[faces[found.faces]])
    owner = scan.faces[atlas.owners.ravel()[atlas.owned]]

    def on_texels(values: Array) -> Array:
        return np.asarray(np.einsum("nc,nc...->n...", atlas.weights, values[owner]))

    places = on_texels(there)
    colour = _linear(albedo.lab(places + _wave(places, random)))
    normals = vertex_normals(body.vertices, faces)
    true_normals = np.einsum("mc,mcd->md", found.barycentric, normals[faces[found.faces]])
    light = _light(true_normals, sky, scan.vertices, random)
    sheet = on_texels(np.where(found.distances > BESIDE, 1.0, 0.0)) > 0.5  # the table
    colour[sheet] = SHEET
    colour *= on_texels(light)
    colour *= 1.0 + 0.015 * random.standard_normal((len(colour), 1))
    blur, quality = float(random.uniform(*BLUR)), int(random.integers(*QUALITY))
    picture = atlas.picture(_encoded(colour))
    picture = gaussian_filter(picture, (blur, blur, 0.0))
    stream = io.BytesIO()
    Image.fromarray(np.rint(255.0 * np.clip(picture, 0.0, 1.0)).astype(np.uint8)).save(stream, "JPEG", quality=quality)
    return Photograph(stream.getvalue(), blur, quality)


def _open_sky(vertices: Array, faces: Integers, random: np.random.Generator) -> Array:
    """(V,) how much of the half space over each vertex is free of near skin, weighted by the cosine."""
    normals = vertex_normals(vertices, faces)
    rays, total = RayCaster(vertices, faces), np.zeros(len(vertices))
    for _ in range(SMALL_RAYS):
        direction = random.standard_normal((len(vertices), 3))
        direction = normals + direction / np.linalg.norm(direction, axis=1, keepdims=True)  # cosine weighted
        direction /= np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-9)
        hit, _ = rays.first_hits(vertices + LIFT * normals, direction, ROOM)
        total += hit < 0
    return np.asarray(total / SMALL_RAYS)


def _light(normals: Array, sky: Array, vertices: Array, random: np.random.Generator) -> Array:
    """(V, 3) light of each colour: the room, two lamps before the body, and the exposure of the nearest view."""
    ambient = random.uniform(*AMBIENT)
    light = ambient * sky[:, None] * (1.0 + random.normal(0.0, 0.02, 3))
    for share in (0.7, 0.3):
        lamp = np.array([random.uniform(-0.8, 0.8), random.uniform(-0.1, 0.8), 1.0])
        cosine = np.maximum(normals @ (lamp / np.linalg.norm(lamp)), 0.0) * (0.3 + 0.7 * sky)
        light = light + (1.15 - ambient) * share * cosine[:, None] * (1.0 + random.normal(0.0, 0.03, 3))
    looks = random.standard_normal((VIEWS, 3)) + np.array([0.0, 0.0, 1.0])
    looks /= np.linalg.norm(looks, axis=1, keepdims=True)
    view = (normals @ looks.T + 0.3 * np.sin(12.0 * vertices @ looks.T)).argmax(axis=1)
    return np.asarray(light * (1.0 + EXPOSURE * random.standard_normal(VIEWS))[view, None])


def _wave(places: Array, random: np.random.Generator) -> Array:
    """(N, 3) m: a slow displacement."""
    shift = np.zeros_like(places)
    for _ in range(4):
        along = 2.0 * np.pi / random.uniform(0.04, 0.15) * random.standard_normal(3) / np.sqrt(3.0)
        wave = np.cos(places @ along + random.uniform(0.0, 2.0 * np.pi))
        shift += MISPLACED / np.sqrt(2.0) * random.standard_normal(3) * wave[:, None]
    return shift


def _linear(lab: Array) -> Array:
    """(N, 3) linear red, green, blue of CIE Lab under D65."""
    height = (np.maximum(lab[:, 0], 1.0) + 16.0) / 116.0
    f = np.stack([height + lab[:, 1] / 500.0, height, height - lab[:, 2] / 200.0], axis=1)
    xyz = np.where(f > 6.0 / 29.0, f**3, 3.0 * (6.0 / 29.0) ** 2 * (f - 4.0 / 29.0)) * [0.95047, 1.0, 1.08883]
    to_rgb = np.array(
        [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
    )
    return np.asarray(np.maximum(xyz @ to_rgb.T, 0.0))


def _encoded(linear: Array) -> Array:
    """sRGB, 0 to 1; bright places saturate as in a camera."""
    clipped = np.clip(linear, 0.0, 1.0)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)

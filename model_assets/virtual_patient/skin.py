"""Colours of skin, areola and table as a cheap camera in a clinic would give them."""

import numpy as np

Array = np.ndarray

SKIN = np.array([0.86, 0.71, 0.63])
AREOLA = np.array([0.70, 0.51, 0.46])
SHEET = np.array([0.55, 0.62, 0.66])
AREOLA_RADIUS = 0.019  # m


def skin_colours(vertices: Array, nipples: dict[str, Array], random: np.random.Generator) -> Array:
    """(V, 3) from 0 to 1: even skin, slowly mottled, darker around the (3,) m nipple tips."""
    mottle = np.zeros(len(vertices))
    for wavelength in (0.25, 0.12, 0.05, 0.03):
        for _ in range(4):
            direction = random.standard_normal(3)
            direction *= 2.0 * np.pi / wavelength / np.linalg.norm(direction)
            mottle += wavelength**0.5 * np.cos(vertices @ direction + random.uniform(0.0, 2.0 * np.pi))
    colours = SKIN * (1.0 + 0.035 * mottle[:, None] * [0.6, 1.0, 1.1])
    for tip in nipples.values():
        away = np.linalg.norm(vertices - tip, axis=1)
        away = away * (1.0 + 0.06 * np.cos(5.0 * np.arctan2(vertices[:, 1] - tip[1], vertices[:, 0] - tip[0])))
        share = 1.0 / (1.0 + np.exp((away - AREOLA_RADIUS) / 0.0016))
        colours = colours + share[:, None] * (AREOLA - colours)
    return colours


def photographed(colours: Array, normals: Array, light: Array, random: np.random.Generator) -> Array:
    """(V, 3) uint8: colours under a soft ceiling light from the (3,) direction `light`, with a camera's noise."""
    bright = 0.86 + 0.17 * (normals @ light)
    noisy = colours * bright[:, None] + 0.008 * random.standard_normal(colours.shape)
    return np.rint(255.0 * np.clip(noisy, 0.0, 1.0)).astype(np.uint8)

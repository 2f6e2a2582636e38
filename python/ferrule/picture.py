"""A picture of the fibre before and in the bore, drawn by NumPy alone."""

from __future__ import annotations

import numpy as np

from . import Observation, Scene

WIDTH, HEIGHT = 480, 360
_BACKGROUND, _FERRULE, _FIBRE, _BAR = (250, 250, 248), (120, 128, 140), (70, 130, 200), (200, 60, 50)


def picture(scene: Scene, tip: np.ndarray, observation: Observation) -> np.ndarray:
    """RGB (360, 480, 3), uint8: the plane of y from above and that of z from below.

    Along the bore it shows from twice the start's distance outside to the success depth; across, the
    clearance is widened so that it can be seen. Below, a bar of the observed force, full width at
    the scene's limit.
    """
    image = np.full((HEIGHT, WIDTH, 3), _BACKGROUND, dtype=np.uint8)
    half = (HEIGHT - 20) // 2
    for plane, top in ((1, 0), (2, half)):
        _plane(image[top : top + half - 4], scene, tip, plane)
    force = np.linalg.norm(observation.wrench[:3]) / scene.force_scale / scene.force_limit
    image[HEIGHT - 14 : HEIGHT - 4, : int(WIDTH * min(1.0, float(force)))] = _BAR
    return image


def _plane(image: np.ndarray, scene: Scene, tip: np.ndarray, plane: int) -> None:
    rows, columns = image.shape[:2]
    left = -1.1 * scene.success_depth
    right = 2 * max(scene.start_distance, 0.2 * scene.success_depth)
    x = np.linspace(left, right, columns)[None, :]
    # A shown radius of 1 is the fibre's; what lies beyond is as it is, over 20 clearances.
    clearance = scene.bore_radius - scene.fibre_radius
    shown = 20 * clearance
    across = np.linspace(1.8, -1.8, rows)[:, None]
    bore = 1 + clearance / shown
    image[(x < 0) & (np.abs(across) > bore)] = _FERRULE
    centre = (tip[plane] + (x - tip[0]) * tip[plane + 2]) / shown
    image[(x > tip[0]) & (np.abs(across - centre) < 1)] = _FIBRE

"""The rigid motion that brings points onto others."""

import numpy as np

from workbench.model.geometry import Floats


def fitted_motion(points: Floats, onto: Floats) -> tuple[Floats, Floats]:
    """Rotation (3, 3) and translation (3,) [m] that bring points (n, 3) [m] nearest to others.

    By the singular value decomposition of their covariance (Arun, Huang and Blostein 1987;
    Umeyama 1991 for the sign); n >= 3, not on one line.
    """
    middle, other = points.mean(axis=0), onto.mean(axis=0)
    u, _, vt = np.linalg.svd((points - middle).T @ (onto - other))
    sign = np.sign(np.linalg.det(vt.T @ u.T))
    rotation = vt.T @ np.diag([1.0, 1.0, sign]) @ u.T
    return rotation, other - rotation @ middle

"""Latitude and longitude (degrees, WGS-84) to metres: local East-North-Up, and KITTI's Mercator
projection.
"""

import numpy as np

# WGS-84 (NIMA TR8350.2): semi-major axis [m] and flattening.
SEMI_MAJOR_AXIS = 6378137.0
FLATTENING = 1.0 / 298.257223563
ECCENTRICITY_SQUARED = FLATTENING * (2.0 - FLATTENING)


def ecef(latitude, longitude, altitude) -> np.ndarray:
    """Earth-centred earth-fixed coordinates (n, 3) [m] of latitude, longitude [deg] and ellipsoidal height
    [m].
    """
    phi, lam = np.radians(latitude), np.radians(longitude)
    normal = SEMI_MAJOR_AXIS / np.sqrt(1.0 - ECCENTRICITY_SQUARED * np.sin(phi) ** 2)
    return np.stack(
        [
            (normal + altitude) * np.cos(phi) * np.cos(lam),
            (normal + altitude) * np.cos(phi) * np.sin(lam),
            (normal * (1.0 - ECCENTRICITY_SQUARED) + altitude) * np.sin(phi),
        ],
        axis=-1,
    )


def local_enu(latitude, longitude, altitude, origin) -> np.ndarray:
    """East, north, up (n, 3) [m] in the plane that touches the ellipsoid at `origin` (latitude, longitude
    [deg], height [m]).
    """
    phi, lam = np.radians(origin[0]), np.radians(origin[1])
    to_enu = np.array(
        [
            [-np.sin(lam), np.cos(lam), 0.0],
            [-np.sin(phi) * np.cos(lam), -np.sin(phi) * np.sin(lam), np.cos(phi)],
            [np.cos(phi) * np.cos(lam), np.cos(phi) * np.sin(lam), np.sin(phi)],
        ]
    )
    points = ecef(np.asarray(latitude), np.asarray(longitude), np.asarray(altitude))
    return (points - ecef(*origin)) @ to_enu.T


def mercator(latitude, longitude, latitude_0: float):
    """KITTI's projection: x east and y north [m], true to scale at `latitude_0` [deg]; returned as a pair of
    arrays.
    """
    scale = np.cos(np.radians(latitude_0))
    x = scale * SEMI_MAJOR_AXIS * np.radians(longitude)
    y = scale * SEMI_MAJOR_AXIS * np.log(np.tan(np.radians(90.0 + np.asarray(latitude)) / 2.0))
    return x, y

"""Rotations and least-squares alignment, vectorised over arrays of poses.

Quaternions are (x, y, z, w) as in TUM files; rotation matrices have shape (n, 3, 3).
"""

import numpy as np

# Axes of a camera (x right, y down, z forward) expressed in a base (x forward, y left, z up): v_base =
# CAMERA_TO_BASE v_camera.
CAMERA_TO_BASE = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def path_length(positions: np.ndarray) -> np.ndarray:
    """Length of the path through positions (n, 3) up to each, (n,)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions, axis=0), axis=1))])


def matrices_from_quaternions(quaternions: np.ndarray) -> np.ndarray:
    """Rotation matrices (n, 3, 3) of quaternions (n, 4) in (x, y, z, w) order, which are normalised first."""
    x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def quaternions_from_matrices(rotations: np.ndarray) -> np.ndarray:
    """Unit quaternions (n, 4), (x, y, z, w), w >= 0, of rotation matrices (n, 3, 3).

    Of the four equivalent formulas the one with the largest divisor is taken (Shepperd 1978): accurate at
    every angle.
    """
    m = rotations
    trace = m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2]
    choice = np.argmax(np.stack([m[:, 0, 0], m[:, 1, 1], m[:, 2, 2], trace], axis=1), axis=1)
    quaternions = np.empty((len(m), 4))
    for k in range(3):
        rows = choice == k
        i, j = (k + 1) % 3, (k + 2) % 3
        a = m[rows]
        quaternions[rows, k] = 1 + 2 * a[:, k, k] - trace[rows]
        quaternions[rows, i] = a[:, i, k] + a[:, k, i]
        quaternions[rows, j] = a[:, j, k] + a[:, k, j]
        quaternions[rows, 3] = a[:, j, i] - a[:, i, j]
    rows = choice == 3
    a = m[rows]
    quaternions[rows, 0] = a[:, 2, 1] - a[:, 1, 2]
    quaternions[rows, 1] = a[:, 0, 2] - a[:, 2, 0]
    quaternions[rows, 2] = a[:, 1, 0] - a[:, 0, 1]
    quaternions[rows, 3] = 1 + trace[rows]
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    return np.where(quaternions[:, 3:] < 0, -quaternions, quaternions)


def rotation_angles(rotations: np.ndarray) -> np.ndarray:
    """Angles [rad], in [0, pi], of rotation matrices (n, 3, 3); accurate near 0 and near pi."""
    quaternions = quaternions_from_matrices(rotations)
    return 2 * np.arctan2(np.linalg.norm(quaternions[:, :3], axis=1), quaternions[:, 3])


def rotation_vectors(rotations: np.ndarray) -> np.ndarray:
    """Axis times angle [rad], (n, 3), of rotation matrices (n, 3, 3)."""
    quaternions = quaternions_from_matrices(rotations)
    norms = np.linalg.norm(quaternions[:, :3], axis=1)
    angles = 2 * np.arctan2(norms, quaternions[:, 3])
    factors = np.where(norms > 0, angles / np.where(norms > 0, norms, 1.0), 2.0)
    return quaternions[:, :3] * factors[:, None]


def rotation_about_z(angle: float) -> np.ndarray:
    """Rotation matrix (3, 3) by `angle` [rad] about z, counter-clockwise positive."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def rotation_about_x(angle: float) -> np.ndarray:
    """Rotation matrix (3, 3) by `angle` [rad] about x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def rotation_about_y(angle: float) -> np.ndarray:
    """Rotation matrix (3, 3) by `angle` [rad] about y."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def rotation_between(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The smallest rotation (3, 3) taking unit vector `source` to unit vector `target`, which are not
    opposite (Rodrigues).
    """
    x, y, z = np.cross(source, target)
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + skew + skew @ skew / (1.0 + source @ target)


def transpose(rotations: np.ndarray) -> np.ndarray:
    """Inverses of rotation matrices (..., 3, 3)."""
    return np.swapaxes(rotations, -1, -2)


def rotate(rotations: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Each rotation (n, 3, 3) applied to its vector (n, 3)."""
    return np.einsum("nij,nj->ni", rotations, vectors)


def twist_about(rotations: np.ndarray, axis: int) -> np.ndarray:
    """The part of each rotation (n, 3, 3) that turns about coordinate axis 0, 1 or 2 (swing-twist
    decomposition).
    """
    quaternions = quaternions_from_matrices(rotations)
    twist = np.zeros_like(quaternions)
    twist[:, axis] = quaternions[:, axis]
    twist[:, 3] = quaternions[:, 3]
    twist[np.linalg.norm(twist, axis=1) == 0, 3] = 1.0
    return matrices_from_quaternions(twist)


def umeyama(reference: np.ndarray, estimate: np.ndarray, with_scale: bool):
    """Least-squares similarity (rotation (3, 3), translation (3,), scale) taking `estimate` (n, 3) onto
    `reference` (n, 3).

    Minimises sum |reference_i - (scale R estimate_i + t)|^2 in closed form; scale is 1 unless asked for.
    Source: Umeyama, Least-squares estimation of transformation parameters between two point patterns, PAMI
    13(4), 1991, eqs. (40)-(42).
    """
    mean_reference, mean_estimate = reference.mean(axis=0), estimate.mean(axis=0)
    centred_reference, centred_estimate = reference - mean_reference, estimate - mean_estimate
    covariance = centred_reference.T @ centred_estimate / len(reference)
    u, singular, vt = np.linalg.svd(covariance)
    signs = np.array([1.0, 1.0, 1.0 if np.linalg.det(u) * np.linalg.det(vt) > 0 else -1.0])
    rotation = u @ np.diag(signs) @ vt
    scale = 1.0
    if with_scale:
        scale = float(singular @ signs / (centred_estimate**2).sum(axis=1).mean())
    return rotation, mean_reference - scale * rotation @ mean_estimate, scale

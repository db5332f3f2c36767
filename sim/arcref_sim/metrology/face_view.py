"""What an autocollimator sees of a polygon's face on a tilted axis, by Rodrigues' formula and without approximation.

The frame stands still: OX is the autocollimator's axis, which is the outward normal of face 1 at the start, OZ the
polygon's axis at the start, OY completes it right-handed. Tian Liude et al., Acta Optica Sinica 35(5) 2015 0512003,
equations (2) to (7), with the term that the print of (5) lost.
"""

import numpy as np

ARCSEC_PER_RAD = np.degrees(1.0) * 3600.0


def tilted_axis(tilt_arcsec: float, tilt_azimuth_deg: float) -> np.ndarray:
    """Unit vector of the shaft's axis: `tilt_arcsec` (psi) off OZ, towards `tilt_azimuth_deg` (omega) from OX to OY."""
    tilt, azimuth = tilt_arcsec / ARCSEC_PER_RAD, np.radians(tilt_azimuth_deg)
    return np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])


def rotated(vector: np.ndarray, axis: np.ndarray, angle_rad) -> np.ndarray:
    """Vectors [..., 3] turned right-handed about the unit vectors `axis` by angles [...]."""
    cosine, sine = np.cos(angle_rad)[..., np.newaxis], np.sin(angle_rad)[..., np.newaxis]
    along = np.sum(vector * axis, axis=-1, keepdims=True)
    return vector * cosine + np.cross(axis, vector) * sine + axis * along * (1 - cosine)


def face_view(face_azimuth_deg, face_pyramid_arcsec, rotation_deg, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal and vertical direction of faces, in arcsec, x towards OY and y towards OZ.

    `face_azimuth_deg`: of the normals on the polygon, from face 1 counter-clockwise; `face_pyramid_arcsec`: their
    elevation; `rotation_deg`: how far the shaft has turned clockwise about `axis` since the start. Arrays broadcast.
    """
    azimuth, elevation = np.radians(face_azimuth_deg), np.asarray(face_pyramid_arcsec) / ARCSEC_PER_RAD
    azimuth, elevation, rotation = np.broadcast_arrays(azimuth, elevation, np.radians(rotation_deg))
    normal = np.stack(
        [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)], axis=-1
    )
    seen = rotated(normal, axis, -rotation)
    x = np.arctan2(seen[..., 1], seen[..., 0]) * ARCSEC_PER_RAD
    return x, np.arctan2(seen[..., 2], seen[..., 0]) * ARCSEC_PER_RAD

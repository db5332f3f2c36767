"""MATLAB's `newrb`, as Yu Hai et al. 2015 used it: a greedy RBF network with an output bias.

One neuron at a time, centred on the input whose Gaussian takes most off the remaining error (orthogonal least squares,
Chen, Cowan and Grant, IEEE Trans. Neural Networks 2 (1991) 302); then weights and bias anew by least squares.
"""

import numpy as np

from arcref.radial_basis_network import gaussian


def newrb(angle_deg, error_arcsec, spread_deg, goal_arcsec2):
    """Mean squared errors in arcsec^2 after 1, 2, 3 ... neurons, until `goal_arcsec2` is met or no input is left."""
    angle, error = np.asarray(angle_deg, float), np.asarray(error_arcsec, float)
    candidates = gaussian(angle[:, np.newaxis] - angle, spread_deg, wrapped=False)
    chosen: list[int] = []
    basis = np.empty((angle.size, 0))  # the bias is no part of the choice, only of the least squares behind it
    found = []
    while len(chosen) < angle.size:
        # Twice: one pass of Gram and Schmidt loses what wide Gaussians have in common.
        rest = candidates
        for _ in range(2):
            rest = rest - basis @ (basis.T @ rest)
        norm = np.linalg.norm(rest, axis=0)
        gain = np.where(norm > 1e-12, (rest.T @ error) ** 2 / np.maximum(norm, 1e-12) ** 2, -1.0)
        gain[chosen] = -1.0
        best = int(np.argmax(gain))
        if gain[best] < 0:
            break
        chosen.append(best)
        basis = np.column_stack([basis, rest[:, best] / norm[best]])
        design = np.column_stack([candidates[:, chosen], np.ones(angle.size)])
        left = error - design @ np.linalg.lstsq(design, error, rcond=None)[0]
        found.append(float(np.mean(left**2)))
        if found[-1] < goal_arcsec2:
            break
    return found

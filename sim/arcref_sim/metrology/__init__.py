"""Calibration runs whose answer is known: an encoder, a polygon and instruments of known truth write run files."""

"""Calibrations of the encoder: from run files to error curves with their uncertainty, and the report people read."""

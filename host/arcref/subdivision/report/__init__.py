"""The report of a calibration within a grating line, whatever way it was measured: page, JSON and table."""

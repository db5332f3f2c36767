"""The report of a calibration: one record of everything, as a page to print, as JSON and as a table."""

"""The error within one grating line (sub-divisional error): its model, its identification and its calibration."""

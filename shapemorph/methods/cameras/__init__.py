"""Calibration of cameras, and what can be measured with calibrated ones."""

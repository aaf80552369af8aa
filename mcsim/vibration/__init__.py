"""Vibration: excitations seen through a sensor, and the analysis of measured or simulated logs."""

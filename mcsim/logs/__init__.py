"""Measured logs: files in, channels in SI units out."""

"""Sensors: from dense truth to samples, and the parameters of their errors."""

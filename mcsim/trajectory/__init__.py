"""Motion in the plane: curves, drives along them, attitude, and positions on the earth."""

from mcsim.trajectory.drive import CurveManoeuvre, Drive, Manoeuvre, Motion

__all__ = ["CurveManoeuvre", "Drive", "Manoeuvre", "Motion"]

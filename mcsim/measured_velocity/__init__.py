"""From recorded runs of a tri-axial accelerometer to a velocity with its uncertainty."""

"""Models: learned, saved and loaded."""

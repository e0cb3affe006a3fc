"""The door: what users import."""

__version__ = "0.1.0"

"""Operators compared, described and drawn for people."""

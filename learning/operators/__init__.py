"""Operators from segments."""

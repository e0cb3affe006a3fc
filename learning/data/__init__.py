"""Demonstrations, and cutting them into segments."""

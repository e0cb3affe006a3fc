"""From demonstrations to skills; the only layer that may use torch."""

"""Demonstrations, and cutting them into segments.

Read ``demonstrations`` (what one is, and how oracle skills make them), then ``segmentation``, which asks
``tracking`` for the atoms along a trajectory. ``files`` is the format on disk, ``arrays`` what it shares with
recordings of the user's own: numbers and names, checked.
"""

"""Evaluations, results in files, and the tables and figures made of them.

Read ``evaluation`` (solving tasks and counting), ``results`` (rows in a file, as each task is done) and
``tables``, the paper's, of many runs; ``summary_text`` and ``drawing`` show them.
"""

"""Evaluations, results in files, and the tables and figures made of them."""

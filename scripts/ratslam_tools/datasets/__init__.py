"""Recordings of every form, and the files that they consist of."""

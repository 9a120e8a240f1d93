"""Readers of recordings and of their files."""

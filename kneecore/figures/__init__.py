"""Figures of results with matplotlib, in one style."""

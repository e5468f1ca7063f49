"""Pieces of HTML, all text in them escaped."""

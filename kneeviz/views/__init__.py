"""Handles of viser: what is drawn and what can be clicked."""

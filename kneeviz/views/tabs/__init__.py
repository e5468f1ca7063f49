"""The panels' tabs with their controls.

Widgets are `Any` here and in the charts: viser's types call a widget's value read-only.
"""

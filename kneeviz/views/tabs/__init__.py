"""The panels' tabs with their controls."""

"""Words and tables for people, from results that are data."""

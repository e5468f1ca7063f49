"""What actions act on: one page with its state, views and running work."""

"""Results on disk: JSON, CSV, folders, and back."""

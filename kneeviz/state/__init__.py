"""What a page knows, without a widget and without a thread."""

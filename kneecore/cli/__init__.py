"""Command lines: options, progress, exit codes. Nothing below imports them."""

"""Long work on threads of its own, and the worker that takes its news."""

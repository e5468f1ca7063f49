"""What can be asked of a model's page, a module a subject."""

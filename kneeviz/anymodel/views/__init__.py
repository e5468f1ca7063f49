"""What a model's page shows: its methods only assign to handles, its functions return text."""

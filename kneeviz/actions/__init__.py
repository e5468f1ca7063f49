"""What a visitor can ask for: one file a subject, and the table of all."""

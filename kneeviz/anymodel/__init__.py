"""The page for a model of one's own: its inputs, outputs and picture, whatever they are."""

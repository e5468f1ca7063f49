"""The paper redone and judged claim by claim. Public names are in `kneecore`."""

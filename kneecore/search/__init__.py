"""The worst-case search, where physics meets numerics. The public names are in `kneecore`."""

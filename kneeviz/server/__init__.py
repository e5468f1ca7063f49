"""The server, its sessions and the kernels' warm-up."""

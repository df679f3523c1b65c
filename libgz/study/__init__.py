"""What learning environments and sweeps share: signals, variants of worlds, distributions."""

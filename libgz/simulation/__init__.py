"""Worlds, models, and how plugin models are found and loaded."""

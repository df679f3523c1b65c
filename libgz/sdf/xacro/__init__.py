"""Expansion of robot descriptions with macros (xacro); `expansion.py` is where it begins."""

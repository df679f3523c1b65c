"""The only package that touches libode: declarations, types, and the step."""

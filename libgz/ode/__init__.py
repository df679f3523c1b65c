"""The only package that touches libode: declarations, types, and the step in its native and its Python form."""

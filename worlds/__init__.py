"""Ready worlds, and the pictures they use; models look here for files that are nowhere else."""

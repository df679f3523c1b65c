"""Ready worlds, and the images they use; models look here for files that are nowhere else."""

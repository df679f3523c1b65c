"""The wire of libgazebo: a directory of memory-mapped files, flock, and System V semaphores."""

"""What every other package stands on: errors, files, waiting, geometry."""

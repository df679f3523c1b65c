"""Recording and replaying worlds in MCAP files; docs/record.md describes what is in such a file."""

"""What RViz shows: markers and handles."""

"""What RViz shows of a fleet, and what its menus do."""

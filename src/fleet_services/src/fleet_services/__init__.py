"""A site as systemd services."""

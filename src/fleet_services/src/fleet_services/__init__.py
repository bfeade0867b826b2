"""Runs a site as systemd services."""

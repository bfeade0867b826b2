"""The node that tells systemd how the others do."""

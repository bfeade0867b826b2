"""The node that reports the state of the other nodes to systemd."""

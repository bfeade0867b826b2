"""The parts of `scripts/soak.sh`."""

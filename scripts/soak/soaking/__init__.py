"""Parts of `scripts/soak.sh`."""

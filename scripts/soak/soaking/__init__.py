"""What `scripts/soak.sh` consists of."""

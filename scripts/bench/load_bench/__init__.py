"""Parts of scripts/bench/load.py."""

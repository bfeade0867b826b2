"""Parts of scripts/bench/supervisor.py."""

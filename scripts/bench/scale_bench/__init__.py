"""What the benchmark `scale` starts and measures."""

"""Parts of the benchmark `scale`."""

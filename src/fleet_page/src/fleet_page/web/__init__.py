"""The HTTP server of the page, a thin layer above the core."""

"""The page over HTTP: thin, above the core."""

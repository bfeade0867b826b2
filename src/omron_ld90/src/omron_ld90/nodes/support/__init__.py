"""What the nodes share: start, parameters, diagnostics, units, messages."""

"""Code that the nodes share: clocks, queues, clicks, links, messages and parameters."""

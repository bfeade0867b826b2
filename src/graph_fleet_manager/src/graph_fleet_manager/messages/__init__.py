"""The one place where messages of `itrci_nav_msgs` become the fleet manager's values, and back.

The original definitions of INESC TEC are not public; adapting to another one is this package, and
`trajectory_graph.messages` for the graph.
"""

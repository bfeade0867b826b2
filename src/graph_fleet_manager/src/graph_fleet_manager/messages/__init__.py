"""The conversion between messages of `itrci_nav_msgs` and the fleet manager's values.

The original definitions of INESC TEC are not public. To adapt to other definitions, only this
package and, for the graph, `trajectory_graph.messages` must change.
"""

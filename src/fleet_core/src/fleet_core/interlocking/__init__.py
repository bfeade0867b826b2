"""The interlocking: it owns the allocation of each robot and grants edges to robots.

A robot drives only edges that `Interlocking.grant` has granted, regardless of the plan. This
package depends on no plan, no planner, no clock, and not on ROS.
"""

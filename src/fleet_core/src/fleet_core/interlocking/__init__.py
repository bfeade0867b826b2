"""The interlocking: it owns the allocation of each robot and grants edges to robots.

A robot drives only edges that `Interlocking.grant` has granted, regardless of the plan. This
package needs no plan, no planner, no clock and no ROS.
"""

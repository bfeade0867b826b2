"""The interlocking: it owns the allocation of each robot and grants edges to robots.

A robot drives only edges that `Interlocking.grant` has granted, regardless of the plan. This
package depends neither on a plan, nor on the planner, nor on ROS, nor on a clock.
"""

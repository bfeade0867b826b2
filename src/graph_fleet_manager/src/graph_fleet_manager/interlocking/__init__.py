"""Which places each robot may occupy: allocations, the evidence for them, and grants.

Neither a plan nor a planner, neither ROS nor a clock: regardless of the plan, robots drive only
what `Interlocking.grant` gives them.
"""

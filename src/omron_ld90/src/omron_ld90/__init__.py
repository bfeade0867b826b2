"""ROS driver of the OMRON LD-90: routes (`bridge`), clicks (`operator`), ROS nodes (`nodes`)."""

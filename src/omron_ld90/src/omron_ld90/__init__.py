"""ROS driver of the OMRON LD-90: routes (`bridge`), maps from graphs (`converter`), nodes."""

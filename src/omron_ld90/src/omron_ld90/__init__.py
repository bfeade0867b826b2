"""Driver of the OMRON LD-90: `arcl` (protocol), `maps` (.map files), `graph`, `nodes` (ROS)."""

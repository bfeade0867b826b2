"""What the robot carries: battery, laser, localization, inputs and outputs."""

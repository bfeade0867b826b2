"""The devices of the robot: battery, laser, localization, inputs and outputs."""

"""Drivers, which set the outputs of devices and read the devices: simulated, or Modbus TCP."""

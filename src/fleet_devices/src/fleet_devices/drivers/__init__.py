"""Drivers, which set the outputs of devices and read the devices: simulated, or by Modbus TCP."""

"""What sets the output of a device and reads it: simulated, or over Modbus TCP."""

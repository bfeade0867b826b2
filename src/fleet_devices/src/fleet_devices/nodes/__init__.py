"""The node `fleet_devices` and its private parts."""

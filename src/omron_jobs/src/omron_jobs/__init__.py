"""The job interface of OMRON's Fleet Manager for a fleet of this workspace: see `core`."""

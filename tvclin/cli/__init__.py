"""The command line: `tvclin`."""

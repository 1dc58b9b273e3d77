"""What stands below everything: checks of arguments, units, files, records shown as tables."""

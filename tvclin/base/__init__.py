"""The base of all chapters: checks of arguments, units, files, records shown as tables."""

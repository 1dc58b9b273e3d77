"""The study file: one TOML that drives studies, campaigns and pages.

The files inside: `plan` is what such a file asks for, `read` makes a plan of a file, and
`read_sizing` the part of the flight; the tables that campaigns know too are read by
`campaign.tables`. The keys of each table are declared beside the value that is made of them.
"""

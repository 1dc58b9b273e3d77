"""The study file: one TOML that drives studies, campaigns and pages.

The files inside: `plan` is what such a file asks for, `read` makes a plan of a file, and `parse` of
its tables; those that campaigns know too are read by `campaign.file`. The keys of each table are
declared beside the value that is made of them.
"""

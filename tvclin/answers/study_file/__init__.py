"""The study file: one TOML that drives studies, campaigns and pages.

The files inside: `plan` is the specification in such a file, `read` makes a plan of a file, and
`parse` of its tables; the tables of campaigns are read by `campaign.file`. The keys of each table
are declared in the file of the value that is made of them.
"""

"""Where answers are shown: one page, a panel in a notebook, the report reproduced."""

"""The page: one self-contained HTML file with the whole answer of a study.

The template ``sections.html`` holds the order of the sections, their headings and their prose; the
findings give tables, notes and figures. ``parts.html`` renders a line, a table or a figure, in
which every number keeps its full precision, and ``page.html`` is the frame with head and links.
`page` renders them, with plots as SVG.
"""

"""The study file: one TOML that drives studies, campaigns and pages.

The rooms inside: `plan` is what such a file asks for, and `read` makes one of a file; the tables
that campaigns know too are read by `campaign.tables`.
"""

from tvclin.study_file.plan import GainsAsked, LawsAsked, StudyPlan
from tvclin.study_file.read import example, example_plan, load_study

__all__ = ["GainsAsked", "LawsAsked", "StudyPlan", "example", "example_plan", "load_study"]

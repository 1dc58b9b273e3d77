"""The study file, with all questions about a vehicle; its findings and verdicts.

`load_study`, `load_sizing` and `load_campaign` read files; `StudyPlan` is a study file as a record,
with its `Document`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)

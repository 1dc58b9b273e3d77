"""The study file, with all questions about a vehicle; its findings and verdicts.

- Which questions has a file? `load_study`, a `StudyPlan` with its `Document`.
- Over a flight, or with dispersions alone? `load_sizing`, `load_campaign`.
"""

from tvclin.base.public_names import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)

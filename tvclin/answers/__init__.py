"""What is asked of the whole: requirement, study, sizing, campaign, and the files that ask."""

from tvclin.base.doors import door

__getattr__, __dir__, __all__ = door(__name__, __file__)

"""What is asked of the whole: requirement, study, sizing, campaign, and the files that ask."""

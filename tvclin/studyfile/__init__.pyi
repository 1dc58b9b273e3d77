from .campaign_file import load_campaign as load_campaign
from .read import load_sizing as load_sizing
from .read import load_study as load_study
from .study_plan import Document as Document
from .study_plan import StudyPlan as StudyPlan

"""tvclin: how much thrust-vector deflection a booster needs to survive a wind.

Everything public stands here; the rooms behind it are loaded when they are first used, so that
``import tvclin`` costs next to nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tvclin.autopilot import Actuator as Actuator
    from tvclin.autopilot import Autopilot as Autopilot
    from tvclin.autopilot import GainSchedule as GainSchedule
    from tvclin.autopilot import canonical_gains as canonical_gains
    from tvclin.autopilot import design_gains as design_gains
    from tvclin.autopilot import drift_minimum_gains as drift_minimum_gains
    from tvclin.autopilot import load_minimum_gains as load_minimum_gains
    from tvclin.autopilot import lqr_gains as lqr_gains
    from tvclin.autopilot import relief_gains as relief_gains
    from tvclin.boundary import BoundaryLimit as BoundaryLimit
    from tvclin.boundary import boundary_limit as boundary_limit
    from tvclin.boundary import triangle_error as triangle_error
    from tvclin.campaign import Campaign as Campaign
    from tvclin.campaign import CampaignResults as CampaignResults
    from tvclin.campaign import DispersedStudy as DispersedStudy
    from tvclin.campaign import Dispersion as Dispersion
    from tvclin.campaign import Dispersions as Dispersions
    from tvclin.campaign import Flight as Flight
    from tvclin.campaign import ShapedWind as ShapedWind
    from tvclin.campaign import WindEnsemble as WindEnsemble
    from tvclin.campaign import disperse_study as disperse_study
    from tvclin.campaign import load_campaign as load_campaign
    from tvclin.campaign import open_campaign as open_campaign
    from tvclin.campaign import resume_campaign as resume_campaign
    from tvclin.campaign import run_campaign as run_campaign
    from tvclin.closed_loop import ClosedLoopBoundary as ClosedLoopBoundary
    from tvclin.closed_loop import FlownCases as FlownCases
    from tvclin.closed_loop import closed_loop_boundary as closed_loop_boundary
    from tvclin.closed_loop import fly as fly
    from tvclin.closed_loop import fly_many as fly_many
    from tvclin.coefficients import Coefficients as Coefficients
    from tvclin.comparison import TrimComparison as TrimComparison
    from tvclin.comparison import WorstDuration as WorstDuration
    from tvclin.comparison import compare_with_trim as compare_with_trim
    from tvclin.comparison import worst_duration as worst_duration
    from tvclin.deflections import BangBang as BangBang
    from tvclin.deflections import HeldDeflection as HeldDeflection
    from tvclin.deflections import trim_deflection as trim_deflection
    from tvclin.deflections import trim_then_hold as trim_then_hold
    from tvclin.errors import InputError as InputError
    from tvclin.explorer import explore as explore
    from tvclin.flight import Earth as Earth
    from tvclin.flight import FlightBeside as FlightBeside
    from tvclin.flight import FlownBoundary as FlownBoundary
    from tvclin.flight import ReportControl as ReportControl
    from tvclin.flight import flown_boundary as flown_boundary
    from tvclin.flight import fly_beside as fly_beside
    from tvclin.flight import fly_planar as fly_planar
    from tvclin.flight import fly_sixdof as fly_sixdof
    from tvclin.forecast_free import ForecastFreeLimit as ForecastFreeLimit
    from tvclin.forecast_free import forecast_free_limit as forecast_free_limit
    from tvclin.histories import History as History
    from tvclin.laws import DeadBandLaw as DeadBandLaw
    from tvclin.laws import Law as Law
    from tvclin.laws import RecoverableAttitudeLaw as RecoverableAttitudeLaw
    from tvclin.laws import SaturatedLaw as SaturatedLaw
    from tvclin.laws import Seen as Seen
    from tvclin.laws import TrimLaw as TrimLaw
    from tvclin.laws import WindEstimator as WindEstimator
    from tvclin.loads import Loads as Loads
    from tvclin.loads import wind_loads as wind_loads
    from tvclin.margins import CRITERIA as CRITERIA
    from tvclin.margins import Criteria as Criteria
    from tvclin.margins import Crossings as Crossings
    from tvclin.margins import Loop as Loop
    from tvclin.margins import Margins as Margins
    from tvclin.margins import loop_margins as loop_margins
    from tvclin.modes import Modes as Modes
    from tvclin.modes import all_modes as all_modes
    from tvclin.modes import unstable_modes as unstable_modes
    from tvclin.optimum import Optimum as Optimum
    from tvclin.optimum import RateLimitedOptimum as RateLimitedOptimum
    from tvclin.optimum import optimum_deflection as optimum_deflection
    from tvclin.optimum import optimum_with_rate_limit as optimum_with_rate_limit
    from tvclin.optimum import single_pole_validity as single_pole_validity
    from tvclin.plant import Plant as Plant
    from tvclin.plant import available_models as available_models
    from tvclin.report import report_html as report_html
    from tvclin.requirement import RequiredDeflection as RequiredDeflection
    from tvclin.requirement import is_sufficient as is_sufficient
    from tvclin.requirement import required_deflection as required_deflection
    from tvclin.requirement import survivable_peak as survivable_peak
    from tvclin.response import Responses as Responses
    from tvclin.response import attitude_response as attitude_response
    from tvclin.response import attitude_responses as attitude_responses
    from tvclin.sizing import DeflectionTotal as DeflectionTotal
    from tvclin.sizing import FlightSchedule as FlightSchedule
    from tvclin.sizing import MeasuredWind as MeasuredWind
    from tvclin.sizing import Sizing as Sizing
    from tvclin.sizing import fly_through as fly_through
    from tvclin.sizing import load_schedule as load_schedule
    from tvclin.sizing import size as size
    from tvclin.sizing import total_deflection as total_deflection
    from tvclin.sizing import worst_total as worst_total
    from tvclin.soundings import Climb as Climb
    from tvclin.soundings import RangeReference as RangeReference
    from tvclin.soundings import WindProfile as WindProfile
    from tvclin.soundings import add_gust as add_gust
    from tvclin.soundings import power_law_shear as power_law_shear
    from tvclin.soundings import read_range_reference as read_range_reference
    from tvclin.soundings import read_sounding as read_sounding
    from tvclin.soundings import steady_climb as steady_climb
    from tvclin.soundings import synthetic_profile as synthetic_profile
    from tvclin.soundings import worst_month as worst_month
    from tvclin.study import Study as Study
    from tvclin.study_file import GainsAsked as GainsAsked
    from tvclin.study_file import LawsAsked as LawsAsked
    from tvclin.study_file import SizingAsked as SizingAsked
    from tvclin.study_file import SoundingAsked as SoundingAsked
    from tvclin.study_file import StudyPlan as StudyPlan
    from tvclin.study_file import load_sizing as load_sizing
    from tvclin.study_file import load_study as load_study
    from tvclin.trials import LawTrial as LawTrial
    from tvclin.trials import law_trials as law_trials
    from tvclin.trials import standard_laws as standard_laws
    from tvclin.trials import standard_winds as standard_winds
    from tvclin.vehicle import Vehicle as Vehicle
    from tvclin.vehicle_file import list_vehicles as list_vehicles
    from tvclin.vehicle_file import load_vehicle as load_vehicle
    from tvclin.verdict import LeftOver as LeftOver
    from tvclin.verdict import Verdict as Verdict
    from tvclin.verdict import is_stable as is_stable
    from tvclin.verdict import judge as judge
    from tvclin.verdict import residues as residues
    from tvclin.winds import AsymmetricTriangularWind as AsymmetricTriangularWind
    from tvclin.winds import LayeredGust as LayeredGust
    from tvclin.winds import OneMinusCosineGust as OneMinusCosineGust
    from tvclin.winds import RectangularWind as RectangularWind
    from tvclin.winds import SampledWind as SampledWind
    from tvclin.winds import TrapezoidalWind as TrapezoidalWind
    from tvclin.winds import TriangularWind as TriangularWind
    from tvclin.winds import angle_from_speed as angle_from_speed
    from tvclin.winds import equivalent_triangle as equivalent_triangle

__version__ = "0.1.0"

_ROOMS = {
    "autopilot": (
        "Actuator",
        "Autopilot",
        "GainSchedule",
        "canonical_gains",
        "design_gains",
        "drift_minimum_gains",
        "load_minimum_gains",
        "lqr_gains",
        "relief_gains",
    ),
    "boundary": (
        "BoundaryLimit",
        "boundary_limit",
        "triangle_error",
    ),
    "campaign": (
        "Campaign",
        "CampaignResults",
        "DispersedStudy",
        "Dispersion",
        "Dispersions",
        "Flight",
        "ShapedWind",
        "WindEnsemble",
        "disperse_study",
        "load_campaign",
        "open_campaign",
        "resume_campaign",
        "run_campaign",
    ),
    "closed_loop": ("ClosedLoopBoundary", "FlownCases", "closed_loop_boundary", "fly", "fly_many"),
    "coefficients": ("Coefficients",),
    "comparison": ("TrimComparison", "WorstDuration", "compare_with_trim", "worst_duration"),
    "deflections": ("BangBang", "HeldDeflection", "trim_deflection", "trim_then_hold"),
    "errors": ("InputError",),
    "explorer": ("explore",),
    "flight": (
        "Earth",
        "FlightBeside",
        "FlownBoundary",
        "ReportControl",
        "flown_boundary",
        "fly_beside",
        "fly_planar",
        "fly_sixdof",
    ),
    "forecast_free": ("ForecastFreeLimit", "forecast_free_limit"),
    "histories": ("History",),
    "trials": ("LawTrial", "law_trials", "standard_laws", "standard_winds"),
    "laws": (
        "DeadBandLaw",
        "Law",
        "RecoverableAttitudeLaw",
        "SaturatedLaw",
        "Seen",
        "TrimLaw",
        "WindEstimator",
    ),
    "loads": ("Loads", "wind_loads"),
    "margins": ("CRITERIA", "Criteria", "Crossings", "Loop", "Margins", "loop_margins"),
    "modes": ("Modes", "all_modes", "unstable_modes"),
    "optimum": (
        "Optimum",
        "RateLimitedOptimum",
        "optimum_deflection",
        "optimum_with_rate_limit",
        "single_pole_validity",
    ),
    "plant": ("Plant", "available_models"),
    "report": ("report_html",),
    "requirement": (
        "RequiredDeflection",
        "is_sufficient",
        "required_deflection",
        "survivable_peak",
    ),
    "response": ("Responses", "attitude_response", "attitude_responses"),
    "soundings": (
        "Climb",
        "RangeReference",
        "WindProfile",
        "add_gust",
        "power_law_shear",
        "read_range_reference",
        "read_sounding",
        "steady_climb",
        "synthetic_profile",
        "worst_month",
    ),
    "sizing": (
        "DeflectionTotal",
        "FlightSchedule",
        "MeasuredWind",
        "Sizing",
        "fly_through",
        "load_schedule",
        "size",
        "total_deflection",
        "worst_total",
    ),
    "study": ("Study",),
    "study_file": (
        "GainsAsked",
        "LawsAsked",
        "SizingAsked",
        "SoundingAsked",
        "StudyPlan",
        "load_sizing",
        "load_study",
    ),
    "vehicle": ("Vehicle",),
    "vehicle_file": ("list_vehicles", "load_vehicle"),
    "verdict": ("LeftOver", "Verdict", "is_stable", "judge", "residues"),
    "winds": (
        "AsymmetricTriangularWind",
        "LayeredGust",
        "OneMinusCosineGust",
        "RectangularWind",
        "SampledWind",
        "TrapezoidalWind",
        "TriangularWind",
        "angle_from_speed",
        "equivalent_triangle",
    ),
}
_HOME = {name: room for room, names in _ROOMS.items() for name in names}

__all__ = sorted(_HOME)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    if name in _HOME:
        found = globals()[name] = getattr(import_module(f"tvclin.{_HOME[name]}"), name)
        return found
    if name in _MODULES:
        return import_module(f"tvclin.{name}")
    raise AttributeError(f"module 'tvclin' has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, *_MODULES, "__version__"]


_MODULES = (*_ROOMS, "plots", "study")

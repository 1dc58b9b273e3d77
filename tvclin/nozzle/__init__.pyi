from .data_sheet import FlightDuty as FlightDuty
from .duty import NozzleDuty as NozzleDuty
from .duty import nozzle_duty as nozzle_duty
from .duty_over_flight import flight_duty as flight_duty
from .flown_trade_off import flown_required_rate as flown_required_rate
from .flown_trade_off import flown_trade_offs as flown_trade_offs

from .data_sheet import FlightCard as FlightCard
from .duty import NozzleCard as NozzleCard
from .duty import nozzle_card as nozzle_card
from .flight_duty import flight_card as flight_card
from .flown_trade_off import flown_trade_offs as flown_trade_offs

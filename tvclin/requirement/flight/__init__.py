"""Required deflection over a flight: flight times by winds, budget and controllability."""

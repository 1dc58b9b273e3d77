"""What commands the deflection: autopilot, margins, laws, and how they compare with trim."""

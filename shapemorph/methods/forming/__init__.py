"""Sheet forming: limits, thickness, cuts through a specimen, domes."""

"""Truth by finite elements: membranes that are pushed or blown, and smooth maps through them."""

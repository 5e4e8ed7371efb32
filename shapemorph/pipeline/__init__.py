"""Order: which stages run, in what order, stored where."""

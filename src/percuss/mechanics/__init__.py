"""What finds motions in every way shares: how coordinates flow between events, in closed form."""

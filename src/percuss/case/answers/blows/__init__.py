"""What a blow by waves is asked: one, a train of them, a motion resolved by them, and what goes into the rock."""

"""A recorded load read as a valve: the implied motion, the edges of the force, ports and delays, the machine."""

"""What a case is asked, and the answers: steady states, simulations, maps; as objects, in words and as JSON."""

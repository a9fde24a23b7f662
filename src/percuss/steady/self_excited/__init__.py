"""The machine that switches its own valve: cycles, what prevents them, margins; the rigid piston in closed form."""

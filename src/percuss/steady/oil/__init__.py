"""The cycle of a machine whose oil flows."""

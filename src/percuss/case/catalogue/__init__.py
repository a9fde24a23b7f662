"""The catalogue: sample cases of real kinds of hammers in ``machines/``, and the recording that one of them names."""

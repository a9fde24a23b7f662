"""The parameters of a case: which it has, and the hammers at other values of them."""

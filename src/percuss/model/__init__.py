"""The ground floor: bar, load and contact, and the system that joins them."""

from percuss.model.bar import Bar
from percuss.model.contact import Contact
from percuss.model.load import Jump, Load
from percuss.model.system import System

__all__ = ["Bar", "Contact", "Jump", "Load", "System"]

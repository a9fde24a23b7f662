"""Contact laws: how a body leaves the wall. `Contact` says what one is; each law is a file.

`Timed` is what a blow that takes time means for the motion of the bar as a whole.
"""

from percuss.model.contact.contact import Contact, Result, impedance_ratio, restitution_of_ratio, restitutions
from percuss.model.contact.kept import Kept
from percuss.model.contact.reversed import Reversed
from percuss.model.contact.timed import ADVANCES, Advance, Timed

LAWS: dict[str, type[Contact]] = {law.kind: law for law in (Kept, Reversed)}  # the laws by their word in case files

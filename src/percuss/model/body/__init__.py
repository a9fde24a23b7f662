"""Bodies: what strikes. `Body` says all that the mechanics may ask of one; each kind of body is a file."""

from percuss.model.body.body import Body, HeldBody, Modes, Shape, need_free
from percuss.model.body.damping import UNDAMPED, Damping, External, KelvinVoigt, Ratio, Table
from percuss.model.body.modal import ModalBody, Mounted, SizedModes, SizedMounted
from percuss.model.body.stepped import Section, SectionedBar, SteppedBar
from percuss.model.body.uniform import Bar, SizedBody, UniformBar

BODIES: dict[str, type[Body]] = {body.kind: body for body in (UniformBar, SteppedBar, Mounted, ModalBody)}
"""The kinds of bodies by their word."""

SIZED_BODIES: dict[str, type[SizedBody]] = {body.kind: body for body in (Bar, SectionedBar, SizedMounted, SizedModes)}
"""The same with sizes in SI."""

DAMPINGS: dict[str, type[Damping]] = {law.kind: law for law in (External, Ratio, KelvinVoigt, Table)}
"""The laws of damping by their word."""

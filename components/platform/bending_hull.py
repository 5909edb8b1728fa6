"""The structure of a hull that bends: what it is told, its frame, and how it is drawn."""

from __future__ import annotations

from functools import lru_cache

from fowtlib.components.hydro.modal_database import ModalDatabase
from fowtlib.components.hydro.modal_loads import read_modal_database
from fowtlib.components.platform.floater import Floater, drawn_between
from fowtlib.components.platform.hull import Hull
from fowtlib.components.platform.member_frame import MemberFrame
from fowtlib.components.platform.member_parts import members_of
from fowtlib.components.platform.shape_numbers import shapes_in_use
from fowtlib.language import Array, Data, Number, Scalar, data, param
from fowtlib.language import shapes as pictures
from fowtlib.language.errors import ParameterError


class BendingHull(Floater):
    """Partial: a hull that bends, without its loads: shapes in use, beams and their material, and its picture."""

    database: Data[ModalDatabase] = data(
        read_modal_database, default=None, doc="potential flow of the hull and its shapes, or none"
    )
    shapes: int = param(default=0, min=0, doc="number of shapes in use; 0: all those of the database")
    attached: int = param(
        default=0, min=0, doc="of the first nodes, without a database: where heavy things stand; each adds six shapes"
    )
    longest: Number = param(default=5.0, unit="m", min=0.1, structural="it divides the frame", doc="longest beam")
    young_modulus: Scalar = param(default=210e9, unit="Pa", min=1.0, doc="Young's modulus of all walls")
    shear_modulus: Scalar = param(default=80.8e9, unit="Pa", min=1.0, doc="shear modulus of all walls")
    damping_time: Scalar = param(default=0.0, unit="s", min=0, doc="damping over stiffness of the structure")
    section_points: Array = param(default=(), unit="m", doc="points (n, 3) on axes of members with section loads")
    drawn_bending: Scalar = param(default=1.0, min=0, doc="how many times its size bending has in pictures")
    node_forces: Array = param(
        default=(), unit="N", doc="forces (n, 3) on the nodes at rest, as far as they change the stiffness; none: zero"
    )

    @property
    def count(self) -> int:
        """How many shapes it has: those of its database, or those it asks for and six for each attached node."""
        known, asked = self.database, self.shapes
        if known is None and not asked:
            raise ParameterError(
                f"{self.label} has neither a database nor shapes: give the one (fowt hydro --shapes), or say how many "
                "shapes of its members are in use, with the water by strips."
            )
        if known is not None and asked not in (0, known.count):
            raise ParameterError(
                f"{self.label}.shapes is {asked}, and its database has {known.count}; leave it out, or take "
                f"ModalDatabase.first({asked})."
            )
        if known is not None and self.attached:
            raise ParameterError(
                f"{self.label}.attached goes without a database; `modal_database` takes the points where things stand."
            )
        nodes = len(self.node_rows())
        if self.attached > nodes:
            raise ParameterError(f"{self.label}.attached is {self.attached}, and there are {nodes} node_points.")
        return known.count if known is not None else asked + 6 * self.attached

    def drawing(self) -> pictures.Drawing:
        """Its beams, each on a frame that moves with the shapes."""
        if not members_of(self):
            return []
        structure, size = self.member_frame(), float(self.parameter_value("drawn_bending"))
        found, of = [], tuple(f"{self.parts['structure'].path}.q[{k}]" for k in range(self.count))
        used = shapes_in_use(self).shapes
        for k, piece in enumerate(structure.pieces):
            axis, motion, _ = structure.frame.section_motion(k, 0.5, used)
            x, y, z = axis.tolist()
            carrier = pictures.Carried(self.frame, (x, y, z), of, size * motion[:, :3].T, size * motion[:, 3:].T)
            found.append(drawn_between(carrier, structure.hull.members[piece.member], piece.low, piece.high, axis))
        return found

    def member_frame(self) -> MemberFrame:
        """Its structure with the values that the parameters have now."""
        moduli = (float(self.parameter_value(name)) for name in ("young_modulus", "shear_modulus"))
        return _frame(self.hull(), float(self.parameter_value("longest")), *moduli)


@lru_cache(maxsize=16)
def _frame(hull: Hull, longest: float, young_modulus: float, shear_modulus: float) -> MemberFrame:
    return MemberFrame(hull, longest, young_modulus, shear_modulus)

"""Mooring lines: elastic catenary with seabed contact, lines with dynamics, systems of lines, linear yaw spring."""

from fowtlib.components.mooring.catenary_line import CatenaryLine
from fowtlib.components.mooring.chain import ChainMooring
from fowtlib.components.mooring.delta_line import CrowFoot, DeltaLine
from fowtlib.components.mooring.drag_anchor import DragAnchor
from fowtlib.components.mooring.dynamic_line import DynamicLine
from fowtlib.components.mooring.line_joint import LineJoint
from fowtlib.components.mooring.mooring_system import MooringSystem
from fowtlib.components.mooring.sectioned_line import SectionedLine
from fowtlib.components.mooring.taut_cables import TautCables
from fowtlib.components.mooring.tendon import Tendon
from fowtlib.components.mooring.tendon_system import TendonSystem
from fowtlib.components.mooring.yaw_spring import YawSpring

__all__ = ["CatenaryLine", "ChainMooring", "CrowFoot", "DeltaLine", "DragAnchor", "DynamicLine", "LineJoint",
           "MooringSystem", "SectionedLine", "TautCables", "Tendon", "TendonSystem", "YawSpring"]  # fmt: skip
